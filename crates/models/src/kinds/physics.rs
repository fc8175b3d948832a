//! An analytical model with its effects as a Gaussian over the motion.

use effects::TrueOutline;
use nalgebra::{Matrix3, Vector3};

use crate::physics::Physics;
use crate::{
    Base, Description, ModelError, Noise, Parts, PushModel, Pushed, StepInput, StepPrediction,
    Unexplained,
};

/// An analytical model with effects, asked about whole steps ([`StepInput::of`]).
///
/// Its covariance is that of the base (scatter, and what the errors of μp and c leave open), what the
/// standard errors of the effects' parameters leave open, by secants, and what those leave open that
/// differ from push to push.
#[derive(Clone, Debug)]
pub(crate) struct PhysicsModel(pub(crate) Physics);

impl PhysicsModel {
    /// Σₖ (Δₖ/2)(Δₖ/2)ᵀ, Δₖ the change of a step's outputs from −1 to +1 standard error of parameter
    /// k of the effects.
    fn effect_covariances(&self, steps: &[&StepInput]) -> Result<Vec<Matrix3<f64>>, ModelError> {
        let mut covariances = vec![Matrix3::zeros(); steps.len()];
        for (index, effect) in self.0.effects.iter().enumerate() {
            for (name, known) in effect.parameters.iter().filter(|(_, known)| known.se > 0.0) {
                let at = |value: f64| {
                    let mut physics = self.0.clone();
                    if let Some(moved) = physics.effects[index].parameters.get_mut(name) {
                        moved.value = value;
                    }
                    physics.outputs(steps)
                };
                let (above, below) = (at(known.value + known.se)?, at(known.value - known.se)?);
                for ((sum, above), below) in covariances.iter_mut().zip(above).zip(below) {
                    let half: Vector3<f64> = 0.5 * (above - below);
                    *sum += half * half.transpose();
                }
            }
        }
        Ok(covariances)
    }

    fn outputs(&self, steps: &[StepInput]) -> Result<Vec<Vector3<f64>>, ModelError> {
        self.0.outputs(&steps.iter().collect::<Vec<_>>())
    }
}

impl PushModel for PhysicsModel {
    fn kind(&self) -> &'static str {
        self.0.base.kind()
    }

    fn predict(
        &self,
        steps: &[StepInput],
        noise: Noise,
    ) -> Result<Vec<StepPrediction>, ModelError> {
        let bare = self.0.base.covariances(steps, noise)?;
        let whole: Vec<&StepInput> = steps.iter().collect();
        let (open, over_pushes) = (self.effect_covariances(&whole)?, self.0.over_pushes(&whole)?);
        let covariances = bare.into_iter().zip(open).zip(over_pushes);
        let covariances = covariances.map(|((bare, open), over_pushes)| bare + open + over_pushes);
        let said = self.outputs(steps)?.into_iter().zip(covariances);
        let said = said.map(|(mean, covariance)| StepPrediction { mean, covariance });
        Ok(said.collect())
    }

    fn parts(&self, steps: &[StepInput]) -> Result<Vec<Parts>, ModelError> {
        Ok(self.outputs(steps)?.into_iter().map(Parts::physical).collect())
    }

    fn unexplained(&self, _steps: &[StepInput]) -> Result<Unexplained, ModelError> {
        Ok(Unexplained::default())
    }

    fn true_outline(&self, pushed: &Pushed) -> Result<TrueOutline, ModelError> {
        self.0.true_outline(pushed)
    }

    fn describe(&self) -> Result<Description, ModelError> {
        let (base, effects) = (Base::Analytical(self.0.base.clone()), self.0.effects.clone());
        Ok(Description { base, effects, weights: None })
    }
}
