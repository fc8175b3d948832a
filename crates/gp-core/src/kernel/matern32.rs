//! The Matérn kernel of order 3/2.

use super::{FARTHEST, KernelSpec, Profile, Radial};
use crate::vector::exp;

/// k(a, b) = s² (1 + √3 r) exp(−√3 r) with r² = Σ_d ((a_d − b_d)/l_d)²: once differentiable functions.
pub type Matern32 = Radial<Matern32Profile>;

/// g(r²) = (1 + √3 r) exp(−√3 r).
#[derive(Clone, Copy, Debug)]
pub struct Matern32Profile;

impl Profile for Matern32Profile {
    const NAME: &'static str = "Matern32";
    const ID: &'static str = "matern32";

    #[inline(always)]
    fn value(squared_distance: f64) -> f64 {
        let scaled = (3.0 * squared_distance.min(FARTHEST)).sqrt();
        let decay = exp(-scaled);
        (1.0 + scaled) * decay
    }

    #[inline(always)]
    fn slope(squared_distance: f64, value: f64) -> f64 {
        -1.5 * value / (1.0 + (3.0 * squared_distance.min(FARTHEST)).sqrt())
    }

    fn spec(kernel: &Matern32) -> Option<KernelSpec> {
        Some(KernelSpec::Matern32 {
            lengthscales: kernel.per_input().clone(),
            signal_variance: kernel.signal_variance(),
        })
    }
}
