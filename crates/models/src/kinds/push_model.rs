//! The trait of every pushing model.

use std::fmt::Debug;

use effects::TrueOutline;

use crate::{
    Description, GpPushModel, ModelError, Noise, Parts, Pushed, SeenSteps, SlipMixture, StepInput,
    StepPrediction, Unexplained,
};

/// A model of what a step of a push does to the object.
pub trait PushModel: Debug + Send + Sync {
    /// The kind's name, as in `model.toml`.
    fn kind(&self) -> &'static str;

    /// A Gaussian over (Δx, Δy, Δθ) for each step.
    ///
    /// # Errors
    /// What the mechanics or the Gaussian processes refuse.
    fn predict(&self, steps: &[StepInput], noise: Noise)
    -> Result<Vec<StepPrediction>, ModelError>;

    /// How many standard normal numbers each push draws, which all its steps share: one for each
    /// parameter that differs from push to push.
    fn n_drawn(&self) -> usize {
        0
    }

    /// The same for steps of pushes that have drawn their numbers, one list a step.
    ///
    /// Over the draws its means have the mean that [`PushModel::predict`] says.
    ///
    /// # Errors
    /// As [`PushModel::predict`].
    fn predict_drawn(
        &self,
        steps: &[StepInput],
        _draws: &[&[f64]],
        noise: Noise,
    ) -> Result<Vec<StepPrediction>, ModelError> {
        self.predict(steps, noise)
    }

    /// Which part of each mean is physics, and which was learnt beside it.
    ///
    /// # Errors
    /// As [`PushModel::predict`].
    fn parts(&self, steps: &[StepInput]) -> Result<Vec<Parts>, ModelError>;

    /// The share of what was learnt in what the model says of some steps.
    ///
    /// # Errors
    /// As [`PushModel::predict`].
    fn unexplained(&self, steps: &[StepInput]) -> Result<Unexplained, ModelError>;

    /// Outline and pusher as the model has them: just as stated, but for what its effects change.
    ///
    /// Whoever asks whether pusher and object touch by this model has to ask these.
    ///
    /// # Errors
    /// `Effects` for what the effects refuse; `EffectsNeedMore` for effects without an object.
    fn true_outline(&self, pushed: &Pushed) -> Result<TrueOutline, ModelError> {
        Ok(pushed.stated())
    }

    /// The same for a push that has drawn its numbers; none where all pushes have the same.
    ///
    /// # Errors
    /// As [`PushModel::true_outline`].
    fn drawn_outline(
        &self,
        _pushed: &Pushed,
        _draw: &[f64],
    ) -> Result<Option<TrueOutline>, ModelError> {
        Ok(None)
    }

    /// The span of the steps that it has learnt from; none of physics alone.
    fn seen(&self) -> Option<&SeenSteps> {
        None
    }

    /// Whether each step is within what it has learnt from; physics alone know all.
    ///
    /// # Errors
    /// `NoSpeed` where the speed is an input and a step has none.
    fn has_seen(&self, steps: &[StepInput]) -> Result<Vec<bool>, ModelError> {
        Ok(vec![true; steps.len()])
    }

    /// The model's ways to go, if it has several: then a roll-out draws one of them for each particle.
    fn as_mixture(&self) -> Option<&SlipMixture> {
        None
    }

    /// The model's processes, if it is nothing else: then what it says of uncertain steps may be known in
    /// closed form ([`crate::Matching::Exact`]).
    fn as_processes(&self) -> Option<&GpPushModel> {
        None
    }

    /// Everything from which the model can be built again.
    ///
    /// # Errors
    /// `Gp` for a kernel that cannot be saved; `NotSaved` for a kind that model files do not know.
    fn describe(&self) -> Result<Description, ModelError>;
}
