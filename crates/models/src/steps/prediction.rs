//! The Gaussian that a model predicts of a step.

use gp_core::GpError;
use nalgebra::{Matrix3, Vector3};

use crate::ModelError;

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
    /// learnt part, 1 without physics; of a hybrid as [`crate::OrthogonalDiscrepancy`] defines it.
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

/// The lower triangular root of a covariance, which may be singular: then it has columns of zeros.
pub(crate) fn root(covariance: &Matrix3<f64>) -> Matrix3<f64> {
    let [xy, xz, yz] = [covariance.m21, covariance.m31, covariance.m32];
    if xy == 0.0 && xz == 0.0 && yz == 0.0 {
        return Matrix3::from_diagonal(
            &covariance.diagonal().map(|variance| variance.max(0.0).sqrt()),
        );
    }
    let mut root = Matrix3::zeros();
    for j in 0..3 {
        let before = |i: usize, k: usize| (0..j).map(|m| root[(i, m)] * root[(k, m)]).sum::<f64>();
        let square = covariance[(j, j)] - before(j, j);
        if square <= 1e-14 * covariance[(j, j)] {
            continue;
        }
        let diagonal = square.sqrt();
        let below: [f64; 3] = std::array::from_fn(|i| {
            if i > j { (covariance[(i, j)] - before(i, j)) / diagonal } else { 0.0 }
        });
        root[(j, j)] = diagonal;
        (j + 1..3).for_each(|i| root[(i, j)] = below[i]);
    }
    root
}

/// An error of the process of an output.
pub(crate) fn of_output(k: usize) -> impl Fn(GpError) -> ModelError {
    move |source| ModelError::Gp { output: OUTPUTS[k], source }
}
