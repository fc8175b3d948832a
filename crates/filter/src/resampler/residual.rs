//! The whole parts for certain, the rest by chance.

use rand::{Rng, RngExt};

use super::{Resampler, holders};

/// Residual resampling: ⌊n·w⌋ copies of each particle, and the missing ones by stratified draws
/// from what is left of the weights.
///
/// # Source
/// Liu & Chen (1998), Sequential Monte Carlo methods for dynamic systems, J. American Statistical
/// Association 93(443).
#[derive(Clone, Copy, Debug, Default)]
pub struct Residual;

/// Products n·w this near to a whole number are whole: 1/n is seldom exact.
const WHOLE: f64 = 1e-9;

impl Resampler for Residual {
    fn id(&self) -> &'static str {
        "residual"
    }

    fn ancestors(&self, weights: &[f64], n: usize, random: &mut dyn Rng) -> Vec<usize> {
        let whole = |weight: &f64| (weight * n as f64 + WHOLE).floor();
        let n_whole: usize = weights.iter().map(|weight| whole(weight) as usize).sum();
        let n_drawn = n.saturating_sub(n_whole);
        let rest: Vec<f64> =
            weights.iter().map(|weight| (weight * n as f64 - whole(weight)).max(0.0)).collect();
        let total: f64 = rest.iter().sum();
        let shares: Vec<f64> = rest.iter().map(|rest| rest / total).collect();
        let drawn =
            holders(&shares, n_drawn, (0..n_drawn).map(|k| k as f64 + random.random::<f64>()));
        let certain = weights.iter().enumerate();
        let certain =
            certain.flat_map(|(k, weight)| std::iter::repeat_n(k, whole(weight) as usize));
        let mut ancestors: Vec<usize> = certain.take(n).chain(drawn).collect();
        ancestors.sort_unstable();
        ancestors
    }

    fn keeps_equal_weights(&self) -> bool {
        true
    }

    fn keeps_heavy_particles(&self) -> bool {
        true
    }
}
