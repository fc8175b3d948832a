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
    /// k of the effects; `outputs` are those of physics with other values.
    fn effect_covariances(
        &self,
        steps: &[&StepInput],
        outputs: impl Fn(&Physics) -> Result<Vec<Vector3<f64>>, ModelError>,
    ) -> Result<Vec<Matrix3<f64>>, ModelError> {
        let mut covariances = vec![Matrix3::zeros(); steps.len()];
        for (index, effect) in self.0.effects.iter().enumerate() {
            for (name, known) in effect.parameters.iter().filter(|(_, known)| known.se > 0.0) {
                let at = |value: f64| {
                    let mut physics = self.0.clone();
                    if let Some(moved) = physics.effects[index].parameters.get_mut(name) {
                        moved.value = value;
                    }
                    outputs(&physics)
                };
                // To one side where the range ends.
                let (low, high) = self.0.range_in(effect, name, steps)?;
                let (high, low) =
                    ((known.value + known.se).min(high), (known.value - known.se).max(low));
                if high <= low {
                    continue;
                }
                let (above, below, part) = (at(high)?, at(low)?, known.se / (high - low));
                for ((sum, above), below) in covariances.iter_mut().zip(above).zip(below) {
                    let half: Vector3<f64> = part * (above - below);
                    *sum += half * half.transpose();
                }
            }
        }
        Ok(covariances)
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
        let open = self.effect_covariances(&whole, |physics| physics.outputs(&whole))?;
        let parts = self.0.over_pushes(&whole)?.into_iter().zip(bare).zip(open);
        let said = parts.map(|(((mean, over_pushes), bare), open)| StepPrediction {
            mean,
            covariance: bare + open + over_pushes,
        });
        Ok(said.collect())
    }

    fn n_drawn(&self) -> usize {
        self.0.n_drawn()
    }

    fn predict_drawn(
        &self,
        steps: &[StepInput],
        draws: &[&[f64]],
        noise: Noise,
    ) -> Result<Vec<StepPrediction>, ModelError> {
        let whole: Vec<&StepInput> = steps.iter().collect();
        let outputs = |physics: &Physics| physics.drawn_outputs(&whole, draws);
        let open = self.effect_covariances(&whole, outputs)?;
        let covariances = self.0.base.covariances(steps, noise)?.into_iter().zip(open);
        let said = outputs(&self.0)?.into_iter().zip(covariances);
        let said =
            said.map(|(mean, (bare, open))| StepPrediction { mean, covariance: bare + open });
        Ok(said.collect())
    }

    fn parts(&self, steps: &[StepInput]) -> Result<Vec<Parts>, ModelError> {
        let outputs = self.0.outputs(&steps.iter().collect::<Vec<_>>())?;
        Ok(outputs.into_iter().map(Parts::physical).collect())
    }

    fn unexplained(&self, _steps: &[StepInput]) -> Result<Unexplained, ModelError> {
        Ok(Unexplained::default())
    }

    fn true_outline(&self, pushed: &Pushed) -> Result<TrueOutline, ModelError> {
        self.0.true_outline(pushed)
    }

    fn drawn_outline(
        &self,
        pushed: &Pushed,
        draw: &[f64],
    ) -> Result<Option<TrueOutline>, ModelError> {
        self.0.drawn_outline(pushed, draw)
    }

    fn describe(&self) -> Result<Description, ModelError> {
        let (base, effects) = (Base::Analytical(self.0.base.clone()), self.0.effects.clone());
        Ok(Description { base, effects, weights: None })
    }
}
