//! Trajectories of particles, drawn backward from the end.

use rand::RngExt;
use rayon::iter::{IntoParallelIterator, ParallelIterator};

use super::ParticleFilter;
use crate::random_stream::{Purpose, stream};
use crate::{FilterError, MotionDensity, Weights};

/// The particles of a filter step by step, from which whole trajectories are drawn, given all
/// measurements: the particle smoother with backward simulation.
///
/// Unlike the ancestors of the last particles, which are few after some resampling, trajectories differ
/// all the way back.
///
/// # Source
/// Godsill, Doucet & West (2004), Monte Carlo smoothing for nonlinear time series, J. American
/// Statistical Association 99(465).
#[derive(Clone, Debug)]
pub struct ParticleHistory<S> {
    steps: Vec<(Vec<S>, Weights)>,
}

impl<S> Default for ParticleHistory<S> {
    fn default() -> Self {
        Self { steps: Vec::new() }
    }
}

impl<S: Clone + Send + Sync> ParticleHistory<S> {
    /// Remembers the particles as they are: at the start, and after the measurements of each step.
    pub fn record(&mut self, filter: &ParticleFilter<'_, S>) {
        self.steps.push((filter.particles.clone(), filter.weights.clone()));
    }

    /// How many steps are remembered.
    #[must_use]
    pub fn len(&self) -> usize {
        self.steps.len()
    }

    /// Whether none is.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.steps.is_empty()
    }

    /// `n` trajectories of equal weight, each with a state of every remembered step; n · (particles of
    /// all steps) densities are asked. The same seed gives the same for any number of threads.
    ///
    /// - `motion`: what led from remembered step k to step k + 1.
    ///
    /// # Errors
    /// `Empty` if nothing is remembered; `Collapsed` if no particle of a step can move to the next state
    /// of a trajectory; `NotANumber` for a density that is none, each with the step that it is from.
    pub fn trajectories<'m, M: MotionDensity<State = S> + 'm>(
        &self,
        motion: impl Fn(usize) -> &'m M + Sync,
        n: usize,
        seed: u64,
    ) -> Result<Vec<Vec<S>>, FilterError> {
        let last = self.steps.len().checked_sub(1).ok_or(FilterError::Empty { what: "steps" })?;
        let trajectory = |number: usize| {
            let mut random = stream(seed, Purpose::Smoothing, number, 0);
            let (particles, weights) = &self.steps[last];
            let mut states = vec![particles[drawn(weights, random.random())].clone()];
            for step in (0..last).rev() {
                let (particles, weights) = &self.steps[step];
                let (motion, next) = (motion(step), &states[states.len() - 1]);
                let densities = particles.iter().map(|state| motion.log_density(state, next));
                let (weights, _) = weights.updated(&densities.collect::<Vec<f64>>(), step)?;
                let state = particles[drawn(&weights, random.random())].clone();
                states.push(state);
            }
            states.reverse();
            Ok(states)
        };
        let trajectories: Vec<_> = (0..n).into_par_iter().map(trajectory).collect();
        trajectories.into_iter().collect()
    }
}

/// The particle in whose share of all weights a place from 0 to 1 lies.
fn drawn(weights: &Weights, mut place: f64) -> usize {
    let weights = weights.as_slice();
    let reached = weights.iter().position(|weight| {
        place -= weight;
        place < 0.0
    });
    // Weights sum to 1 but for rounding.
    reached.or(weights.iter().rposition(|weight| *weight > 0.0)).unwrap_or_default()
}
