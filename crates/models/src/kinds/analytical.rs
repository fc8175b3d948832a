//! The analytical model as one of the pushing models.

use crate::{
    Analytical, Base, Description, ModelError, Noise, Parts, PushModel, StepInput, StepPrediction,
    Unexplained,
};

impl PushModel for Analytical {
    fn kind(&self) -> &'static str {
        "analytical"
    }

    fn predict(
        &self,
        steps: &[StepInput],
        noise: Noise,
    ) -> Result<Vec<StepPrediction>, ModelError> {
        let said = self.outputs(steps)?.into_iter().zip(self.covariances(steps, noise)?);
        Ok(said.map(|(mean, covariance)| StepPrediction { mean, covariance }).collect())
    }

    fn parts(&self, steps: &[StepInput]) -> Result<Vec<Parts>, ModelError> {
        Ok(self.outputs(steps)?.into_iter().map(Parts::physical).collect())
    }

    fn unexplained(&self, _steps: &[StepInput]) -> Result<Unexplained, ModelError> {
        Ok(Unexplained::default())
    }

    fn describe(&self) -> Result<Description, ModelError> {
        Ok(Description { base: Base::Analytical(self.clone()), effects: Vec::new(), weights: None })
    }
}
