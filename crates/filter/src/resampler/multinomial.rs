//! Independent draws.

use rand::{Rng, RngExt};

use super::{Resampler, holders};

/// Multinomial resampling: n independent draws, the plainest and the noisiest.
///
/// # Source
/// Gordon, Salmond & Smith (1993), Novel approach to nonlinear/non-Gaussian Bayesian state
/// estimation, IEE Proceedings F 140(2).
#[derive(Clone, Copy, Debug, Default)]
pub struct Multinomial;

impl Resampler for Multinomial {
    fn id(&self) -> &'static str {
        "multinomial"
    }

    fn ancestors(&self, weights: &[f64], n: usize, random: &mut dyn Rng) -> Vec<usize> {
        let mut positions: Vec<f64> = (0..n).map(|_| random.random::<f64>() * n as f64).collect();
        positions.sort_by(f64::total_cmp);
        holders(weights, n, positions.into_iter())
    }

    fn keeps_equal_weights(&self) -> bool {
        false
    }

    fn keeps_heavy_particles(&self) -> bool {
        false
    }
}
