//! As many particles as the distribution needs.

use std::collections::HashSet;
use std::hash::Hash;

use rand::RngExt;

use super::{ParticleFilter, advance};
use crate::random_stream::{CHUNK, Purpose, stream};
use crate::slab::quantile;
use crate::{FilterError, MotionModel, Weights};

/// How many particles: enough that they and the distribution that they are drawn from hardly diverge.
///
/// # Source
/// Fox (2003), Adapting the sample size in particle filters through KLD-sampling, Int. J. Robotics
/// Research 22(12).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KldSampling {
    /// The divergence of Kullback and Leibler that is allowed, in nats, positive.
    pub divergence: f64,
    /// How probably it is kept, between 0 and 1.
    pub confidence: f64,
    /// At least so many particles, 1 or more.
    pub least: usize,
    /// At most so many.
    pub most: usize,
}

impl Default for KldSampling {
    fn default() -> Self {
        Self { divergence: 0.05, confidence: 0.99, least: 100, most: 100_000 }
    }
}

impl KldSampling {
    /// How many particles a distribution over `n_bins` bins needs.
    ///
    /// The quantile of χ² with k − 1 degrees of freedom by Wilson and Hilferty, over twice the
    /// divergence, within least and most.
    #[must_use]
    pub fn n_particles(&self, n_bins: usize) -> usize {
        let degrees = n_bins.saturating_sub(1) as f64;
        let shrink = 2.0 / (9.0 * degrees.max(1.0));
        let cube = 1.0 - shrink + shrink.sqrt() * quantile(self.confidence);
        let needed = degrees / (2.0 * self.divergence) * cube.powi(3);
        (needed.ceil() as usize).max(self.least).min(self.most)
    }

    fn check(&self) -> Result<(), FilterError> {
        let out = |name, expected, value| Err(FilterError::OutOfRange { name, expected, value });
        if !(self.divergence > 0.0 && self.divergence.is_finite()) {
            return out("divergence", "positive and finite", self.divergence);
        }
        if !(self.confidence > 0.0 && self.confidence < 1.0) {
            return out("confidence", "between 0 and 1", self.confidence);
        }
        if self.least == 0 || self.least > self.most {
            return out("least particles", "from 1 to the most", self.least as f64);
        }
        Ok(())
    }
}

impl<S: Clone + Send + Sync> ParticleFilter<'_, S> {
    /// Draws particles by their weights and moves them by one step, until there are as many as the bins
    /// ask for that they moved into; returns the number of these bins. All weights are equal then.
    ///
    /// - `bin`: the bin of a state, such as its place and heading in whole steps of a grid.
    ///
    /// # Errors
    /// As [`ParticleFilter::predict`]; `OutOfRange` for the sampling. The filter is then as before.
    pub fn predict_adaptively<M: MotionModel<State = S>, B: Hash + Eq>(
        &mut self,
        motion: &M,
        sampling: &KldSampling,
        bin: impl Fn(&S) -> B,
    ) -> Result<usize, FilterError> {
        sampling.check()?;
        let seed = self.settings.seed;
        let ends: Vec<f64> = self.weights.as_slice().iter().scan(0.0, cumulate).collect();
        let total = ends[ends.len() - 1];
        let (mut moved, mut bins) = (Vec::new(), HashSet::new());
        let (mut needed, mut first_chunk) = (sampling.n_particles(0), 0);
        while moved.len() < needed {
            let mut random = stream(seed, Purpose::Resampling, self.n_resampled, first_chunk);
            let drawn = (moved.len()..needed).map(|_| {
                let position = random.random::<f64>() * total;
                let holder = ends.partition_point(|end| *end <= position);
                self.particles[holder.min(ends.len() - 1)].clone()
            });
            let mut drawn: Vec<S> = drawn.collect();
            advance(motion, &mut drawn, (seed, self.step), first_chunk)?;
            first_chunk += drawn.len().div_ceil(CHUNK);
            bins.extend(drawn.iter().map(&bin));
            moved.append(&mut drawn);
            needed = sampling.n_particles(bins.len());
        }
        self.weights = Weights::equal(moved.len());
        self.particles = moved;
        self.step += 1;
        self.n_resampled += 1;
        Ok(bins.len())
    }
}

#[allow(clippy::unnecessary_wraps, reason = "`scan` asks for an option")]
fn cumulate(sum: &mut f64, weight: &f64) -> Option<f64> {
    *sum += weight;
    Some(*sum)
}
