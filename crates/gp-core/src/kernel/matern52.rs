//! The Matérn kernel of order 5/2.

use super::{FARTHEST, KernelSpec, Profile, Radial};
use crate::vector::exp;

/// k(a, b) = s² (1 + √5 r + 5r²/3) exp(−√5 r) with r² = Σ_d ((a_d − b_d)/l_d)²: twice differentiable.
pub type Matern52 = Radial<Matern52Profile>;

/// g(r²) = (1 + √5 r + 5r²/3) exp(−√5 r).
#[derive(Clone, Copy, Debug)]
pub struct Matern52Profile;

impl Profile for Matern52Profile {
    const NAME: &'static str = "Matern52";
    const ID: &'static str = "matern52";

    #[inline(always)]
    fn value(squared_distance: f64) -> f64 {
        let scaled = (5.0 * squared_distance.min(FARTHEST)).sqrt();
        let decay = exp(-scaled);
        (1.0 + scaled + scaled * scaled / 3.0) * decay
    }

    #[inline(always)]
    fn slope(squared_distance: f64, value: f64) -> f64 {
        let scaled = (5.0 * squared_distance.min(FARTHEST)).sqrt();
        let polynomial = 1.0 + scaled + scaled * scaled / 3.0;
        -5.0 / 6.0 * (1.0 + scaled) * value / polynomial
    }

    fn spec(kernel: &Matern52) -> Option<KernelSpec> {
        Some(KernelSpec::Matern52 {
            lengthscales: kernel.per_input().clone(),
            signal_variance: kernel.signal_variance(),
        })
    }
}
