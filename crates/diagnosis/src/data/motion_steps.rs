//! Observed steps as models of the motion alone see them.

use dataset::SupportSpec;
use models::{StepInput, StepObservation};
use nalgebra::Vector3;

use crate::{DiagnosisError, Observations};

impl Observations {
    /// What models of the motion are asked, one a step.
    ///
    /// # Errors
    /// `Model` for a pusher at rest.
    pub fn motion_inputs(&self) -> Result<Vec<StepInput>, DiagnosisError> {
        Ok(StepInput::all_of(self.steps.iter().map(|step| &step.input))?)
    }

    /// The steps whose motion was observed, to learn from.
    ///
    /// # Errors
    /// As [`Observations::motion_inputs`].
    pub fn motion_steps(&self) -> Result<Vec<StepObservation>, DiagnosisError> {
        let step = |(input, step): (StepInput, &models::ChannelObservation)| {
            let [dx, dy, dtheta, ..] = step.observed;
            Some(StepObservation { input, outputs: Vector3::new(dx?, dy?, dtheta?) })
        };
        Ok(self.motion_inputs()?.into_iter().zip(&self.steps).filter_map(step).collect())
    }

    /// The nominal table.
    pub fn support(&self) -> SupportSpec {
        self.support
    }
}
