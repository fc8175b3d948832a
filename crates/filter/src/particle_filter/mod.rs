//! Particles that move, are weighed and are drawn anew.

mod adaptive;
mod auxiliary;
mod backward;
mod rao_blackwellized;

use rand::Rng;
use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};
use rayon::slice::ParallelSliceMut;

pub use self::adaptive::KldSampling;
pub use self::backward::ParticleHistory;
pub use self::rao_blackwellized::RaoBlackwellized;
use crate::random_stream::{CHUNK, Purpose, stream};
use crate::{DrawnMotion, FilterError, MeasurementModel, MotionModel, Settings, Weights};

/// A distribution over states, as weighted particles.
///
/// The same seed gives the same particles for any number of threads.
///
/// # Source
/// Gordon, Salmond & Smith (1993); Thrun, Burgard & Fox, Probabilistic Robotics (2005), chapter 4.
#[derive(Clone, Debug)]
pub struct ParticleFilter<'a, S> {
    particles: Vec<S>,
    weights: Weights,
    settings: Settings<'a>,
    /// Motions made; streams of random numbers are named by it.
    step: usize,
    /// Resamplings made.
    n_resampled: usize,
}

/// What a measurement did.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Update {
    /// Log density of the measurement given all before it.
    pub log_evidence: f64,
    /// Effective sample size with the new weights, before any resampling.
    pub effective_size: f64,
    /// Whether particles were drawn anew.
    pub resampled: bool,
    /// Particles that were injected.
    pub n_injected: usize,
}

impl<'a, S: Clone + Send + Sync> ParticleFilter<'a, S> {
    /// Particles of equal weight.
    ///
    /// # Errors
    /// `Empty` without particles; `OutOfRange` for a setting.
    pub fn new(particles: Vec<S>, settings: Settings<'a>) -> Result<Self, FilterError> {
        settings.check()?;
        if particles.is_empty() {
            return Err(FilterError::Empty { what: "particles" });
        }
        let weights = Weights::equal(particles.len());
        Ok(Self { particles, weights, settings, step: 0, n_resampled: 0 })
    }

    /// The particles.
    #[must_use]
    pub fn particles(&self) -> &[S] {
        &self.particles
    }

    /// Their weights.
    #[must_use]
    pub fn weights(&self) -> &Weights {
        &self.weights
    }

    /// Motions made so far.
    #[must_use]
    pub fn step(&self) -> usize {
        self.step
    }

    /// Moves every particle by one step.
    ///
    /// # Errors
    /// `Motion` with what the model says.
    pub fn predict<M: MotionModel<State = S>>(&mut self, motion: &M) -> Result<(), FilterError> {
        let (seed, step) = (self.settings.seed, self.step);
        advance(motion, &mut self.particles, (seed, step), 0)?;
        self.step += 1;
        Ok(())
    }

    /// Moves every particle and multiplies its weight by the density of its own draw.
    ///
    /// The rule of Bauza (2017), which sharpens the distribution although nothing was measured:
    /// kept to reproduce that thesis. [`ParticleFilter::predict`] is right.
    ///
    /// # Errors
    /// As [`ParticleFilter::predict`] and [`ParticleFilter::update`].
    pub fn predict_weighted_by_density<M: DrawnMotion<State = S>>(
        &mut self,
        motion: &M,
    ) -> Result<Update, FilterError> {
        let (seed, step) = (self.settings.seed, self.step);
        let mut densities = vec![0.0; self.particles.len()];
        let chunks = self.particles.par_chunks_mut(CHUNK).zip(densities.par_chunks_mut(CHUNK));
        let advance = |(chunk, (states, densities)): (usize, (&mut [S], &mut [f64]))| {
            let mut random = stream(seed, Purpose::Motion, step, chunk);
            motion.advance_with_density(states, densities, &mut random)
        };
        first_error(chunks.enumerate().map(advance).collect(), step)?;
        self.step += 1;
        self.weigh(&densities)
    }

    /// Weighs the particles by a measurement, and resamples where the settings ask for it.
    ///
    /// # Errors
    /// `Collapsed` if no particle can explain the measurement, `NotANumber` for a likelihood that
    /// is none; the filter is then as before.
    pub fn update<Z: MeasurementModel<State = S>>(
        &mut self,
        measurement: &Z,
    ) -> Result<Update, FilterError> {
        self.weigh(&self.log_likelihoods(measurement))
    }

    /// As [`ParticleFilter::update`], by the log likelihood of each particle as it was computed elsewhere:
    /// for measurements that are evaluated for all particles at once.
    ///
    /// - `log_likelihoods`: of the measurement, one a particle, up to a constant; −∞ where it is impossible.
    ///
    /// # Errors
    /// As [`ParticleFilter::update`]; `ShapeMismatch` for another number of them than of particles.
    pub fn update_by(&mut self, log_likelihoods: &[f64]) -> Result<Update, FilterError> {
        self.weigh(log_likelihoods)
    }

    /// As [`ParticleFilter::update`], but replaces a share of the particles by draws of
    /// `inject` first if the measurement's log evidence is below `least_log_evidence`.
    ///
    /// The injected particles have the mean weight.
    ///
    /// # Errors
    /// As [`ParticleFilter::update`], if the injected particles cannot explain it either;
    /// `OutOfRange` for a share beyond 0 to 1.
    pub fn update_or_inject<Z: MeasurementModel<State = S>>(
        &mut self,
        measurement: &Z,
        (least_log_evidence, share): (f64, f64),
        inject: impl Fn(&mut dyn Rng) -> S,
    ) -> Result<Update, FilterError> {
        if !(0.0..=1.0).contains(&share) {
            let (name, expected) = ("share of injected particles", "from 0 to 1");
            return Err(FilterError::OutOfRange { name, expected, value: share });
        }
        let likelihoods = self.log_likelihoods(measurement);
        match self.weights.updated(&likelihoods, self.step) {
            Ok((_, evidence)) if evidence >= least_log_evidence => self.weigh(&likelihoods),
            Ok(_) | Err(FilterError::Collapsed { .. }) => {
                let n_injected = self.inject(share, inject);
                let likelihoods = self.log_likelihoods(measurement);
                Ok(Update { n_injected, ..self.weigh(&likelihoods)? })
            }
            Err(error) => Err(error),
        }
    }

    /// Draws all particles anew by their weights, which become equal.
    pub fn resample(&mut self) {
        let Settings { seed, resampler, .. } = self.settings;
        let mut random = stream(seed, Purpose::Resampling, self.n_resampled, 0);
        let n = self.particles.len();
        let ancestors = resampler.ancestors(self.weights.as_slice(), n, &mut random);
        self.particles = ancestors.par_iter().map(|k| self.particles[*k].clone()).collect();
        self.weights = Weights::equal(n);
        self.n_resampled += 1;
    }

    fn log_likelihoods<Z: MeasurementModel<State = S>>(&self, measurement: &Z) -> Vec<f64> {
        self.particles.par_iter().map(|state| measurement.log_likelihood(state)).collect()
    }

    fn weigh(&mut self, log_likelihoods: &[f64]) -> Result<Update, FilterError> {
        let (weights, log_evidence) = self.weights.updated(log_likelihoods, self.step)?;
        Ok(self.accept(weights, log_evidence))
    }

    fn accept(&mut self, weights: Weights, log_evidence: f64) -> Update {
        self.weights = weights;
        let effective_size = self.weights.effective_size();
        let n = self.particles.len() as f64;
        let resampled = effective_size < self.settings.resample_below * n;
        if resampled {
            self.resample();
        }
        Update { log_evidence, effective_size, resampled, n_injected: 0 }
    }

    /// Resamples, and replaces particles at even distances by draws.
    fn inject(&mut self, share: f64, inject: impl Fn(&mut dyn Rng) -> S) -> usize {
        self.resample();
        let n = self.particles.len();
        let n_injected = (share * n as f64).ceil() as usize;
        let mut random = stream(self.settings.seed, Purpose::Injection, self.n_resampled, 0);
        for k in 0..n_injected {
            self.particles[k * n / n_injected] = inject(&mut random);
        }
        n_injected
    }
}

/// Moves particles, of which the first is in a chunk.
fn advance<M: MotionModel>(
    motion: &M,
    particles: &mut [M::State],
    (seed, step): (u64, usize),
    first_chunk: usize,
) -> Result<(), FilterError> {
    let chunks = particles.par_chunks_mut(CHUNK).enumerate();
    let advance = |(chunk, states): (usize, &mut [M::State])| {
        motion.advance(states, &mut stream(seed, Purpose::Motion, step, first_chunk + chunk))
    };
    first_error(chunks.map(advance).collect(), step)
}

/// The error of the first chunk that has one, whichever thread came first.
fn first_error<E: std::error::Error + Send + Sync + 'static>(
    results: Vec<Result<(), E>>,
    step: usize,
) -> Result<(), FilterError> {
    let failed = results.into_iter().find_map(Result::err);
    failed.map_or(Ok(()), |source| Err(FilterError::Motion { step, source: source.into() }))
}
