//! The analytical model with learnt processes on what it leaves over.

use effects::TrueOutline;
use gp_core::{LearnOptions, Mean};
use nalgebra::Vector3;

use crate::analytical::fit::output_sd;
use crate::learnt::step_processes::StepProcesses;
use crate::physics::{Physics, Setup};
use crate::{
    Analytical, Base, Description, ModelEffect, ModelError, Noise, OrthogonalDiscrepancy, Parts,
    ProcessReport, PushModel, Pushed, SeenSteps, StepInput, StepObservation, StepPrediction,
    Training, Unexplained, Weights,
};

/// An analytical model with its effects, plus three independent processes on its residuals.
///
/// The processes have mean zero: far from the training steps the physics alone speak. The scatter
/// is that which the processes have learnt; what the standard errors of the physics leave open is
/// added.
#[derive(Clone, Debug)]
pub struct Hybrid {
    physics: Physics,
    processes: StepProcesses,
    beside: OrthogonalDiscrepancy,
}

/// How the training of a hybrid went.
#[derive(Clone, Debug, PartialEq)]
pub struct HybridReport {
    /// Of Δx, Δy and Δθ.
    pub processes: [ProcessReport; 3],
    /// Parameters of the physics that the steps do not determine: they were kept as they were.
    pub kept: Vec<String>,
}

impl Hybrid {
    /// Learns the residuals of `analytical` as it is with exact processes of (p, β), whatever
    /// `options` say of the mean about a mean of zero; O(N³).
    ///
    /// What is learnt may be what other parameters of the model would explain: [`Hybrid::train`]
    /// fits them, and tells the two apart.
    ///
    /// # Errors
    /// As [`crate::GpPushModel::learn`], and those of the analytical model.
    pub fn learn(
        analytical: Analytical,
        steps: &[StepObservation],
        options: &LearnOptions,
    ) -> Result<(Self, [ProcessReport; 3]), ModelError> {
        let physics = Physics::new(analytical, Vec::new(), None)?;
        let (processes, reports) = residual_processes(&physics, steps, &options.clone().into())?;
        let inputs: Vec<_> = steps.iter().map(|step| &step.input).collect();
        let learnt = processes.means(&inputs)?;
        let beside =
            OrthogonalDiscrepancy::unprojected(&physics, output_sd(steps)?, &inputs, &learnt)?;
        Ok((Self { physics, processes, beside }, reports))
    }

    /// Fits the physics of an analytical model with its effects to observed steps, and learns what
    /// it leaves over, orthogonal to everything that was fitted: see [`OrthogonalDiscrepancy`].
    ///
    /// Fitted are μp, on an ellipsoid c, and the numbers of the effects, as far as the steps
    /// determine them; `setup` is what effects act in.
    ///
    /// # Errors
    /// `NoPhysics` for a base without mechanics; `EffectsNeedMore` for effects without a set-up or
    /// bare steps; those of a fit and of [`crate::GpPushModel::train`].
    pub fn train(
        base: &Description,
        setup: Option<Setup>,
        steps: &[StepObservation],
        training: &Training,
    ) -> Result<(Self, HybridReport), ModelError> {
        let analytical = match &base.base {
            Base::Analytical(analytical) | Base::Hybrid(analytical) => analytical.clone(),
            Base::Process(kind) => return Err(ModelError::NoPhysics { kind: kind.id() }),
        };
        let fit = Physics::new(analytical, base.effects.clone(), setup)?.fit(steps)?;
        let (processes, reports) = residual_processes(&fit.physics, steps, training)?;
        let inputs: Vec<_> = steps.iter().map(|step| &step.input).collect();
        let beside = OrthogonalDiscrepancy::of(&fit, &inputs, &processes.means(&inputs)?)?;
        let hybrid = Self { physics: fit.physics, processes, beside };
        Ok((hybrid, HybridReport { processes: reports, kept: fit.kept }))
    }

    /// The model underneath, without its effects.
    pub fn analytical(&self) -> &Analytical {
        &self.physics.base
    }

    /// The effects of the model underneath.
    pub fn effects(&self) -> &[ModelEffect] {
        &self.physics.effects
    }

    /// What is learnt beside it.
    pub fn orthogonal_discrepancy(&self) -> &OrthogonalDiscrepancy {
        &self.beside
    }

    /// f and h of each step.
    fn physics_and_left(&self, steps: &[StepInput]) -> Result<[Vec<Vector3<f64>>; 2], ModelError> {
        let Some(first) = steps.first() else { return Ok([Vec::new(), Vec::new()]) };
        let inputs: Vec<_> = steps.iter().collect();
        let slopes = self.physics.jacobian(&self.beside.free(&self.physics, first)?, &inputs)?;
        let left = self.beside.left(&self.processes.means(&inputs)?, &slopes);
        Ok([self.physics.outputs(&inputs)?, left])
    }

    /// What the model says of steps of which the processes and the physics say this.
    fn said(
        &self,
        steps: &[StepInput],
        mut predictions: Vec<StepPrediction>,
        outputs: &[Vector3<f64>],
    ) -> Result<Vec<StepPrediction>, ModelError> {
        let Some(first) = steps.first() else { return Ok(predictions) };
        let inputs: Vec<_> = steps.iter().collect();
        let learnt: Vec<_> = predictions.iter().map(|prediction| prediction.mean).collect();
        let (left, open) = if self.beside.parameters.is_empty() {
            // The scatter of the base is in the residuals, from which the processes learnt theirs.
            (learnt, self.physics.base.covariances(steps, Noise::Excluded)?)
        } else {
            let slopes =
                self.physics.jacobian(&self.beside.free(&self.physics, first)?, &inputs)?;
            let open = (0..steps.len()).map(|i| self.beside.covariance_at(&slopes, i));
            (self.beside.left(&learnt, &slopes), open.collect())
        };
        for (i, prediction) in predictions.iter_mut().enumerate() {
            prediction.mean = outputs[i] + left[i];
            prediction.covariance += open[i];
        }
        Ok(predictions)
    }

    pub(crate) fn from_weights(physics: Physics, weights: &Weights) -> Result<Self, ModelError> {
        let beside = weights.orthogonal_discrepancy.clone().filter(OrthogonalDiscrepancy::is_sound);
        Ok(Self {
            physics,
            processes: StepProcesses::from_weights(weights)?,
            beside: beside.ok_or(ModelError::UnsoundWeights { what: "orthogonal_discrepancy" })?,
        })
    }
}

/// Processes on what the physics leave over.
fn residual_processes(
    physics: &Physics,
    steps: &[StepObservation],
    training: &Training,
) -> Result<(StepProcesses, [ProcessReport; 3]), ModelError> {
    let inputs: Vec<_> = steps.iter().map(|step| &step.input).collect();
    let residuals = physics.errors(steps)?;
    let options = LearnOptions { mean: Mean::Fixed(0.0), ..training.options.clone() };
    StepProcesses::learn(&inputs, &residuals, &Training { options, ..training.clone() })
}

impl PushModel for Hybrid {
    fn kind(&self) -> &'static str {
        "hybrid"
    }

    fn predict(
        &self,
        steps: &[StepInput],
        noise: Noise,
    ) -> Result<Vec<StepPrediction>, ModelError> {
        let physics = self.physics.outputs(&steps.iter().collect::<Vec<_>>())?;
        self.said(steps, self.processes.predict(steps, noise)?, &physics)
    }

    fn n_drawn(&self) -> usize {
        self.physics.n_drawn()
    }

    /// What pushes draw is in the residuals, from which the processes learnt their scatter: it is taken
    /// off that, output by output, as they were learnt.
    fn predict_drawn(
        &self,
        steps: &[StepInput],
        draws: &[&[f64]],
        noise: Noise,
    ) -> Result<Vec<StepPrediction>, ModelError> {
        let inputs: Vec<_> = steps.iter().collect();
        let drawn = self.physics.drawn_outputs(&inputs, draws)?;
        let mut learnt = self.processes.predict(steps, noise)?;
        if noise == Noise::Included {
            let over_pushes = self.physics.over_pushes(&inputs)?;
            for (learnt, (_, over_pushes)) in learnt.iter_mut().zip(&over_pushes) {
                let left = learnt.covariance.diagonal() - over_pushes.diagonal();
                learnt.covariance.set_diagonal(&left.map(|variance| variance.max(0.0)));
            }
        }
        self.said(steps, learnt, &drawn)
    }

    fn parts(&self, steps: &[StepInput]) -> Result<Vec<Parts>, ModelError> {
        let [physics, left] = self.physics_and_left(steps)?;
        let part = |i: usize| {
            let (physics, unexplained) = (physics[i], left[i]);
            let unexplained_share = self.beside.share(&steps[i], &physics, &unexplained);
            Parts { physics, unexplained, unexplained_share }
        };
        Ok((0..steps.len()).map(part).collect())
    }

    fn unexplained(&self, steps: &[StepInput]) -> Result<Unexplained, ModelError> {
        let [physics, left] = self.physics_and_left(steps)?;
        let inputs: Vec<_> = steps.iter().collect();
        Ok(self.beside.unexplained_of(&inputs, &physics, &left))
    }

    fn true_outline(&self, pushed: &Pushed) -> Result<TrueOutline, ModelError> {
        self.physics.true_outline(pushed)
    }

    fn drawn_outline(
        &self,
        pushed: &Pushed,
        draw: &[f64],
    ) -> Result<Option<TrueOutline>, ModelError> {
        self.physics.drawn_outline(pushed, draw)
    }

    fn seen(&self) -> Option<&SeenSteps> {
        self.processes.seen()
    }

    fn has_seen(&self, steps: &[StepInput]) -> Result<Vec<bool>, ModelError> {
        self.processes.has_seen(steps)
    }

    fn describe(&self) -> Result<Description, ModelError> {
        let base = Base::Hybrid(self.physics.base.clone());
        let mut weights = self.processes.weights()?;
        weights.orthogonal_discrepancy = Some(self.beside.clone());
        Ok(Description { base, effects: self.physics.effects.clone(), weights: Some(weights) })
    }
}
