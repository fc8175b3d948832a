//! Learnt processes, and mixtures of them, as pushing models.

use crate::{
    Base, Description, GpPushModel, ModelError, Noise, Parts, PushModel, SeenSteps, SlipMixture,
    SlipPrediction, StepInput, StepPrediction, Unexplained,
};

impl PushModel for GpPushModel {
    fn kind(&self) -> &'static str {
        self.processes.kind().id()
    }

    fn predict(
        &self,
        steps: &[StepInput],
        noise: Noise,
    ) -> Result<Vec<StepPrediction>, ModelError> {
        self.processes.predict(steps, noise)
    }

    fn parts(&self, steps: &[StepInput]) -> Result<Vec<Parts>, ModelError> {
        let means = self.processes.means(&steps.iter().collect::<Vec<_>>())?;
        Ok(means.into_iter().map(Parts::learnt).collect())
    }

    fn unexplained(&self, _steps: &[StepInput]) -> Result<Unexplained, ModelError> {
        Ok(Unexplained::ALL)
    }

    fn seen(&self) -> Option<&SeenSteps> {
        self.processes.seen()
    }

    fn has_seen(&self, steps: &[StepInput]) -> Result<Vec<bool>, ModelError> {
        self.processes.has_seen(steps)
    }

    fn as_processes(&self) -> Option<&GpPushModel> {
        Some(self)
    }

    fn describe(&self) -> Result<Description, ModelError> {
        let base = Base::Process(self.processes.kind());
        Ok(Description { base, effects: Vec::new(), weights: Some(self.processes.weights()?) })
    }
}

impl PushModel for SlipMixture {
    fn kind(&self) -> &'static str {
        "slip-mixture"
    }

    /// The Gaussians of the same moments.
    fn predict(
        &self,
        steps: &[StepInput],
        noise: Noise,
    ) -> Result<Vec<StepPrediction>, ModelError> {
        Ok(self.ways(steps, noise)?.iter().map(SlipPrediction::moments).collect())
    }

    fn parts(&self, steps: &[StepInput]) -> Result<Vec<Parts>, ModelError> {
        let said = self.predict(steps, Noise::Excluded)?;
        Ok(said.into_iter().map(|said| Parts::learnt(said.mean)).collect())
    }

    fn unexplained(&self, _steps: &[StepInput]) -> Result<Unexplained, ModelError> {
        Ok(Unexplained::ALL)
    }

    fn seen(&self) -> Option<&SeenSteps> {
        self.seen.as_ref()
    }

    fn has_seen(&self, steps: &[StepInput]) -> Result<Vec<bool>, ModelError> {
        let Some(seen) = &self.seen else { return Ok(vec![true; steps.len()]) };
        Ok(steps.iter().map(|step| seen.holds(&[step.p(), step.beta()])).collect())
    }

    fn as_mixture(&self) -> Option<&SlipMixture> {
        Some(self)
    }

    fn describe(&self) -> Result<Description, ModelError> {
        Err(ModelError::NotSaved { kind: self.kind() })
    }
}
