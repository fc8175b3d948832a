//! The trait of every pushing model, and the Gaussian that it predicts.

use std::fmt::Debug;

use nalgebra::{Matrix3, Vector3};

use crate::{Description, ModelError, StepInput};

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

    /// Everything from which the model can be built again.
    ///
    /// # Errors
    /// `Gp` for a kernel that cannot be saved.
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

/// The names of the three outputs, in order.
pub const OUTPUTS: [&str; 3] = ["dx", "dy", "dtheta"];
