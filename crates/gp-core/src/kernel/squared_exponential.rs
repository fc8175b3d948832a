//! The squared-exponential kernel.

use super::{KernelSpec, Profile, Radial};
use crate::vector::exp;

/// k(a, b) = s² exp(−½ Σ_d ((a_d − b_d)/l_d)²): infinitely smooth functions.
///
/// The thesis prints eq. 3.17 without the squares; this is the right form.
pub type SquaredExponential = Radial<SquaredExponentialProfile>;

/// g(r²) = exp(−r²/2).
#[derive(Clone, Copy, Debug)]
pub struct SquaredExponentialProfile;

impl Profile for SquaredExponentialProfile {
    const NAME: &'static str = "SquaredExponential";
    const ID: &'static str = "squared_exponential";
    const NEEDS_DISTANCE: bool = false;

    #[inline(always)]
    fn value(squared_distance: f64) -> f64 {
        exp(-0.5 * squared_distance)
    }

    #[inline(always)]
    fn slope(_squared_distance: f64, value: f64) -> f64 {
        -0.5 * value
    }

    fn spec(kernel: &SquaredExponential) -> Option<KernelSpec> {
        Some(KernelSpec::SquaredExponential {
            lengthscales: kernel.per_input().clone(),
            signal_variance: kernel.signal_variance(),
        })
    }
}
