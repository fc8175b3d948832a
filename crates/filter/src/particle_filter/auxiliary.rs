//! Particles that are drawn anew with an eye on the measurement that comes.

use rayon::iter::{IntoParallelRefIterator, ParallelIterator};

use super::{ParticleFilter, Update, advance};
use crate::random_stream::{Purpose, stream};
use crate::{FilterError, MeasurementModel, MotionModel, Weights};

impl<S: Clone + Send + Sync> ParticleFilter<'_, S> {
    /// A step and its measurement by the auxiliary particle filter: those are drawn to move on that will
    /// probably explain the measurement, and what was foreseen wrongly is put right by the weights.
    ///
    /// Better than [`ParticleFilter::predict`] and [`ParticleFilter::update`] where measurements tell far
    /// more than the motion.
    ///
    /// - `foresight`: for a state before the motion, the log likelihood that is expected after it, such as
    ///   the measurement's at the mean of the motion. It may be rough, but must not be −∞ where the
    ///   measurement is possible.
    ///
    /// # Errors
    /// As [`ParticleFilter::predict`] and [`ParticleFilter::update`], also for what is foreseen; the
    /// filter is then as before.
    ///
    /// # Source
    /// Pitt & Shephard (1999), Filtering via simulation: auxiliary particle filters, J. American
    /// Statistical Association 94(446).
    pub fn auxiliary_step<M: MotionModel<State = S>, Z: MeasurementModel<State = S>>(
        &mut self,
        motion: &M,
        measurement: &Z,
        foresight: impl Fn(&S) -> f64 + Sync,
    ) -> Result<Update, FilterError> {
        let (seed, n) = (self.settings.seed, self.particles.len());
        let foreseen: Vec<f64> = self.particles.par_iter().map(&foresight).collect();
        let (first, log_first) = self.weights.updated(&foreseen, self.step)?;
        let mut random = stream(seed, Purpose::Resampling, self.n_resampled, 0);
        let ancestors = self.settings.resampler.ancestors(first.as_slice(), n, &mut random);
        let mut particles: Vec<S> =
            ancestors.par_iter().map(|k| self.particles[*k].clone()).collect();
        advance(motion, &mut particles, (seed, self.step), 0)?;
        let likelihoods = particles.par_iter().map(|state| measurement.log_likelihood(state));
        let likelihoods: Vec<f64> = likelihoods.collect();
        let corrected = likelihoods.iter().zip(&ancestors).map(|(seen, k)| seen - foreseen[*k]);
        let corrected: Vec<f64> = corrected.collect();
        let (second, log_second) = Weights::equal(n).updated(&corrected, self.step + 1)?;
        self.particles = particles;
        self.step += 1;
        self.n_resampled += 1;
        let update = self.accept(second, log_first + log_second);
        Ok(Update { resampled: true, ..update })
    }
}
