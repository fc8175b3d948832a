//! The analytical model with Gaussian processes on what it leaves over.

use gp_core::{LearnOptions, LearnReport};

use crate::step_gps::StepGps;
use crate::{
    Analytical, Base, Description, ModelError, Noise, PushModel, StepInput, StepObservation,
    StepPrediction, Weights,
};

/// An analytical model plus three independent Gaussian processes on its residuals.
///
/// Far from the training steps it falls back to the analytical model and the residuals' mean; the
/// scatter is that which the processes have learnt.
#[derive(Clone, Debug)]
pub struct Hybrid {
    analytical: Analytical,
    gps: StepGps,
}

impl Hybrid {
    /// Learns the residuals of `analytical` from observed steps; O(N³).
    ///
    /// # Errors
    /// As [`crate::GpPushModel::learn`], and those of the analytical model.
    pub fn learn(
        analytical: Analytical,
        steps: &[StepObservation],
        options: &LearnOptions,
    ) -> Result<(Self, [LearnReport; 3]), ModelError> {
        let inputs: Vec<_> = steps.iter().map(|step| &step.input).collect();
        let residuals: Result<Vec<_>, _> =
            steps.iter().map(|step| analytical.error(step)).collect();
        let (gps, reports) = StepGps::learn(&inputs, &residuals?, options)?;
        Ok((Self { analytical, gps }, reports))
    }

    /// The model underneath.
    pub fn analytical(&self) -> &Analytical {
        &self.analytical
    }

    pub(crate) fn from_weights(
        analytical: Analytical,
        weights: &Weights,
    ) -> Result<Self, ModelError> {
        Ok(Self { analytical, gps: StepGps::from_weights(weights)? })
    }
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
        let mut predictions = self.gps.predict(steps, noise)?;
        for (prediction, step) in predictions.iter_mut().zip(steps) {
            prediction.mean += self.analytical.outputs(step)?;
        }
        Ok(predictions)
    }

    fn describe(&self) -> Result<Description, ModelError> {
        let base = Base::Hybrid(self.analytical.clone());
        Ok(Description { base, weights: Some(self.gps.weights()?) })
    }
}
