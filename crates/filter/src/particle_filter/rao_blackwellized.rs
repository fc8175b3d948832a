//! Particles of which each carries a Gaussian.

use std::error::Error;

use nalgebra::DVector;
use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};

use super::{ParticleFilter, Update};
use crate::{
    DifferentiableMeasurement, FilterError, Gaussian, GaussianMeasurement, GaussianUpdate,
    PlanarState, Rule,
};

/// A state of which a part is drawn, and the rest is a Gaussian given that part.
///
/// What is linear given the drawn part needs no particles: they are few, and never wrong about it.
/// A motion ([`crate::MotionModel`]) draws the one and carries the other ([`Gaussian::predicted`]); where
/// the drawn part moves by what the Gaussian says, it conditions the Gaussian on its draw.
///
/// # Source
/// Doucet, de Freitas, Murphy & Russell (2000), Rao-Blackwellised particle filtering for dynamic
/// Bayesian networks; Schön, Gustafsson & Nordlund (2005), Marginalized particle filters for mixed
/// linear/nonlinear state-space models, IEEE Trans. Signal Processing 53(7).
#[derive(Clone, Debug, PartialEq)]
pub struct RaoBlackwellized<S> {
    /// The part that is drawn.
    pub drawn: S,
    /// The rest, given it.
    pub gaussian: Gaussian,
}

impl<S: PlanarState> PlanarState for RaoBlackwellized<S> {
    fn planar(&self) -> [f64; 3] {
        self.drawn.planar()
    }
}

impl<S: Clone + Send + Sync> ParticleFilter<'_, RaoBlackwellized<S>> {
    /// Conditions each particle's Gaussian on a measurement ([`Gaussian::updated`]), weighs the particle
    /// by its evidence, and resamples where the settings ask for it.
    ///
    /// - `measurement`: of the Gaussian part, for a drawn part.
    ///
    /// # Errors
    /// `Measurement` with the first particle that cannot be updated, and why; else as
    /// [`ParticleFilter::update`]. The filter is then as before.
    pub fn condition<Z: DifferentiableMeasurement, E: Error + Send + Sync + 'static>(
        &mut self,
        measurement: impl Fn(&S) -> Result<Z, E> + Sync,
    ) -> Result<Update, FilterError> {
        self.condition_each(|state| Ok(state.gaussian.updated(&measurement(&state.drawn)?)?))
    }

    /// As [`ParticleFilter::condition`], by a rule's points ([`Gaussian::updated_by`]).
    ///
    /// # Errors
    /// As [`ParticleFilter::condition`].
    pub fn condition_by<Z, E>(
        &mut self,
        rule: &dyn Rule,
        measurement: impl Fn(&S) -> Result<Z, E> + Sync,
    ) -> Result<Update, FilterError>
    where
        Z: GaussianMeasurement<State = DVector<f64>>,
        E: Error + Send + Sync + 'static,
    {
        self.condition_each(|state| {
            Ok(state.gaussian.updated_by(rule, &measurement(&state.drawn)?)?)
        })
    }

    fn condition_each(
        &mut self,
        update: impl Fn(&RaoBlackwellized<S>) -> Result<GaussianUpdate, Box<dyn Error + Send + Sync>>
        + Sync,
    ) -> Result<Update, FilterError> {
        let step = self.step;
        let updates: Vec<_> = self.particles.par_iter().map(&update).collect();
        let updates = updates.into_iter().enumerate().map(|(particle, updated)| {
            updated.map_err(|source| FilterError::Measurement { step, particle, source })
        });
        let updates = updates.collect::<Result<Vec<_>, FilterError>>()?;
        let evidences: Vec<f64> = updates.iter().map(|update| update.log_evidence).collect();
        let (weights, log_evidence) = self.weights.updated(&evidences, step)?;
        for (state, update) in self.particles.iter_mut().zip(updates) {
            state.gaussian = update.posterior;
        }
        Ok(self.accept(weights, log_evidence))
    }

    /// The one Gaussian of the same mean and covariance as the Gaussian parts of all particles.
    ///
    /// # Errors
    /// `ShapeMismatch` if they differ in dimension.
    pub fn moments(&self) -> Result<Gaussian, FilterError> {
        let weighted = self.particles.par_iter().zip(self.weights.as_slice().par_iter());
        let parts: Vec<(Gaussian, f64)> =
            weighted.map(|(state, weight)| (state.gaussian.clone(), *weight)).collect();
        Gaussian::of_mixture(&parts)
    }
}
