//! The state of a push whose uncertainty is a Gaussian.

use filter::Gaussian;

/// The state of a push: x and y in m, the angle in rad, the gap that contact holds beyond the nominal
/// one in m, and three numbers that neighboring steps share, times the push's size.
pub(super) const N_STATES: usize = 7;
/// How much of it is the pose.
pub(super) const N_POSE: usize = 3;
/// Which of it neighboring steps share.
pub(super) const SHARED: std::ops::Range<usize> = N_POSE + 1..N_STATES;

/// The mean square of a push's size, by the numbers that steps share.
pub(super) fn mean_square_size(state: &Gaussian) -> f64 {
    let (mean, covariance) = (state.mean(), state.covariance());
    SHARED.map(|k| covariance[(k, k)] + mean[k] * mean[k]).sum::<f64>() / SHARED.len() as f64
}
