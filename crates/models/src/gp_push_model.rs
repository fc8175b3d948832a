//! The model that knows no mechanics: Gaussian processes learnt from observed steps.

use gp_core::{LearnOptions, LearnReport};

use crate::step_gps::StepGps;
use crate::{
    Base, Description, ModelError, Noise, PushModel, StepInput, StepObservation, StepPrediction,
    Weights,
};

/// Three independent Gaussian processes from (p, β) to the outputs per meter of the pusher's way.
///
/// The object and the edge are not inputs: train and use it on one object whose edges are alike,
/// at step lengths near those of the training.
#[derive(Clone, Debug)]
pub struct GpPushModel {
    gps: StepGps,
}

impl GpPushModel {
    /// Learns from observed steps; the reports are those of Δx, Δy and Δθ. O(N³).
    ///
    /// # Errors
    /// `Gp` for fewer than two steps, outputs that do not vary, or a likelihood without maximum.
    pub fn learn(
        steps: &[StepObservation],
        options: &LearnOptions,
    ) -> Result<(Self, [LearnReport; 3]), ModelError> {
        let inputs: Vec<_> = steps.iter().map(|step| &step.input).collect();
        let targets: Vec<_> = steps.iter().map(|step| step.outputs).collect();
        let (gps, reports) = StepGps::learn(&inputs, &targets, options)?;
        Ok((Self { gps }, reports))
    }

    pub(crate) fn from_weights(weights: &Weights) -> Result<Self, ModelError> {
        Ok(Self { gps: StepGps::from_weights(weights)? })
    }
}

impl PushModel for GpPushModel {
    fn kind(&self) -> &'static str {
        "gp"
    }

    fn predict(
        &self,
        steps: &[StepInput],
        noise: Noise,
    ) -> Result<Vec<StepPrediction>, ModelError> {
        self.gps.predict(steps, noise)
    }

    fn describe(&self) -> Result<Description, ModelError> {
        Ok(Description { base: Base::Gp, effects: Vec::new(), weights: Some(self.gps.weights()?) })
    }
}
