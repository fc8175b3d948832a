//! A random number for each of n equal strata.

use rand::{Rng, RngExt};

use super::{Resampler, holders};

/// Stratified resampling: one position, drawn, in each of n equal parts of [0, 1).
///
/// # Source
/// Kitagawa (1996), as for [`crate::Systematic`].
#[derive(Clone, Copy, Debug, Default)]
pub struct Stratified;

impl Resampler for Stratified {
    fn id(&self) -> &'static str {
        "stratified"
    }

    fn ancestors(&self, weights: &[f64], n: usize, random: &mut dyn Rng) -> Vec<usize> {
        holders(weights, n, (0..n).map(|k| k as f64 + random.random::<f64>()))
    }

    fn keeps_equal_weights(&self) -> bool {
        true
    }

    fn keeps_heavy_particles(&self) -> bool {
        false
    }
}
