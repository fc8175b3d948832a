//! The Matérn kernel of order 1/2.

use super::{FARTHEST, KernelSpec, Profile, Radial};
use crate::vector::exp;

/// k(a, b) = s² exp(−r) with r² = Σ_d ((a_d − b_d)/l_d)²: continuous functions with kinks everywhere.
pub type Matern12 = Radial<Matern12Profile>;

/// g(r²) = exp(−r).
#[derive(Clone, Copy, Debug)]
pub struct Matern12Profile;

impl Profile for Matern12Profile {
    const NAME: &'static str = "Matern12";
    const ID: &'static str = "matern12";

    #[inline(always)]
    fn value(squared_distance: f64) -> f64 {
        exp(-squared_distance.min(FARTHEST).sqrt())
    }

    /// Infinite at no distance, where all that it is multiplied by is 0.
    #[inline(always)]
    fn slope(squared_distance: f64, value: f64) -> f64 {
        -0.5 * value / squared_distance.clamp(f64::MIN_POSITIVE, FARTHEST).sqrt()
    }

    fn spec(kernel: &Matern12) -> Option<KernelSpec> {
        Some(KernelSpec::Matern12 {
            lengthscales: kernel.per_input().clone(),
            signal_variance: kernel.signal_variance(),
        })
    }
}
