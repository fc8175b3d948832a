//! How particles are drawn anew by their weights.

mod multinomial;
mod residual;
mod stratified;
mod systematic;

use std::fmt::Debug;

use rand::Rng;

pub use multinomial::Multinomial;
pub use residual::Residual;
pub use stratified::Stratified;
pub use systematic::Systematic;

/// A way to draw n particles by their weights.
///
/// Every resampler is unbiased: particle i is expected n·wᵢ times.
pub trait Resampler: Debug + Sync {
    /// Lower-case name.
    fn id(&self) -> &'static str;

    /// Indices of `n` drawn particles, ascending. `weights` are not negative and sum to 1.
    fn ancestors(&self, weights: &[f64], n: usize, random: &mut dyn Rng) -> Vec<usize>;

    /// Whether n draws from n equal weights are each particle once.
    fn keeps_equal_weights(&self) -> bool;

    /// Whether a particle of weight 1/n or more is always drawn.
    fn keeps_heavy_particles(&self) -> bool;
}

/// Every resampler.
#[must_use]
pub fn all_resamplers() -> [&'static dyn Resampler; 4] {
    [&Systematic, &Stratified, &Residual, &Multinomial]
}

/// The particles whose shares of [0, n) hold ascending positions in [0, n).
fn holders(weights: &[f64], n: usize, positions: impl Iterator<Item = f64>) -> Vec<usize> {
    let last = weights.iter().rposition(|weight| *weight > 0.0).unwrap_or_default();
    let (mut index, mut end) = (0, weights.first().copied().unwrap_or_default());
    let mut holder = |position: f64| {
        while index < last && position >= end * n as f64 {
            index += 1;
            end += weights[index];
        }
        index
    };
    positions.map(&mut holder).collect()
}
