//! One random number for all: positions at equal distances.

use rand::{Rng, RngExt};

use super::{Resampler, holders};

/// Low-variance resampling: n positions at distance 1/n behind one random start.
///
/// # Source
/// Kitagawa (1996), Monte Carlo filter and smoother for non-Gaussian nonlinear state space models.
#[derive(Clone, Copy, Debug, Default)]
pub struct Systematic;

impl Resampler for Systematic {
    fn id(&self) -> &'static str {
        "systematic"
    }

    fn ancestors(&self, weights: &[f64], n: usize, random: &mut dyn Rng) -> Vec<usize> {
        let start: f64 = random.random();
        holders(weights, n, (0..n).map(|k| k as f64 + start))
    }

    fn keeps_equal_weights(&self) -> bool {
        true
    }

    fn keeps_heavy_particles(&self) -> bool {
        true
    }
}
