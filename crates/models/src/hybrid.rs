//! The analytical model with Gaussian processes on what it leaves over.

use gp_core::{LearnOptions, LearnReport, Mean};

use crate::step_gps::StepGps;
use crate::{
    Analytical, Base, Description, ModelError, Noise, PushModel, StepInput, StepObservation,
    StepPrediction, Weights,
};

/// An analytical model plus three independent Gaussian processes on its residuals.
///
/// The processes have mean zero: far from the training steps the analytical model alone speaks. The
/// scatter is that which the processes have learnt; what the standard errors of the analytical
/// parameters leave open is added.
#[derive(Clone, Debug)]
pub struct Hybrid {
    analytical: Analytical,
    gps: StepGps,
}

impl Hybrid {
    /// Learns the residuals of `analytical` from observed steps, whatever `options` say of the mean
    /// about a mean of zero; O(N³).
    ///
    /// # Errors
    /// As [`crate::GpPushModel::learn`], and those of the analytical model.
    pub fn learn(
        analytical: Analytical,
        steps: &[StepObservation],
        options: &LearnOptions,
    ) -> Result<(Self, [LearnReport; 3]), ModelError> {
        let inputs: Vec<_> = steps.iter().map(|step| &step.input).collect();
        let residuals = analytical.errors(steps)?;
        let options = LearnOptions { mean: Mean::Fixed(0.0), ..options.clone() };
        let (gps, reports) = StepGps::learn(&inputs, &residuals, &options)?;
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
        // The scatter of the base is in the residuals, from which the processes learnt theirs.
        let base = self.analytical.predict(steps, Noise::Excluded)?;
        for (prediction, base) in predictions.iter_mut().zip(base) {
            prediction.mean += base.mean;
            prediction.covariance += base.covariance;
        }
        Ok(predictions)
    }

    fn describe(&self) -> Result<Description, ModelError> {
        let base = Base::Hybrid(self.analytical.clone());
        Ok(Description { base, effects: Vec::new(), weights: Some(self.gps.weights()?) })
    }
}
