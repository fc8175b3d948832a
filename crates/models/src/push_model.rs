//! The trait of every pushing model, and the Gaussian that it predicts.

use std::fmt::Debug;

use effects::TrueOutline;
use nalgebra::{Matrix3, Vector3};

use crate::{
    Description, GpPushModel, ModelError, Pushed, SeenSteps, SlipMixture, StepInput, Unexplained,
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

/// Whose motion a prediction's covariance is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Noise {
    /// An observed step: what the model does not know, and what scatters between repeats.
    Included,
    /// The model's own function: what it does not know of it, without scatter.
    Excluded,
}

/// A Gaussian over (Δx, Δy, Δθ): m along the pusher's motion, m along its left normal, and rad
/// counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepPrediction {
    /// The expected outputs.
    pub mean: Vector3<f64>,
    /// Their covariance; zero for a deterministic model without fitted scatter.
    pub covariance: Matrix3<f64>,
}

/// The mean of a prediction as the sum of what physics says and what was learnt from data without a
/// reason.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parts {
    /// What the mechanics say, in the outputs' units.
    pub physics: Vector3<f64>,
    /// What was learnt, in the same units.
    pub unexplained: Vector3<f64>,
    /// The share of what was learnt in what the model says of this step, from 0 to 1: 0 without
    /// learnt part, 1 without physics; of a hybrid as [`crate::BesidePhysics`] defines it.
    pub unexplained_share: f64,
}

impl Parts {
    /// All of it is physics.
    pub(crate) fn physical(physics: Vector3<f64>) -> Self {
        Self { physics, unexplained: Vector3::zeros(), unexplained_share: 0.0 }
    }

    /// All of it is learnt.
    pub(crate) fn learnt(unexplained: Vector3<f64>) -> Self {
        Self { physics: Vector3::zeros(), unexplained, unexplained_share: 1.0 }
    }
}

/// The names of the three outputs, in order.
pub const OUTPUTS: [&str; 3] = ["dx", "dy", "dtheta"];
