//! Predictions with the slopes of everything that may move them.

use std::sync::Arc;

use effects::{Effect, tested};
use models::Description;

use crate::predict::candidates::Candidates;
use crate::predict::error_shapes::push_directions;
use crate::predict::secants::{Direction, Linearisation};
use crate::{DiagnosisError, Observations};

/// A model linearised on some observations: by the parameters that differ from push to push, and by
/// every effect.
#[derive(Clone, Debug)]
pub(crate) struct Tangent {
    pub(crate) candidates: Candidates,
    /// Its first slopes are [`push_directions`].
    pub(crate) linearisation: Linearisation,
    n_of_push: usize,
}

impl Tangent {
    /// At a model; `own` are effects besides those of the catalogue.
    ///
    /// # Errors
    /// `Model` for what the model refuses, such as a learnt one.
    pub(crate) fn of(
        model: &Description,
        own: &[Arc<dyn Effect>],
        observations: &Observations,
    ) -> Result<Self, DiagnosisError> {
        Self::among(tested().iter().chain(own), model, own, observations)
    }

    /// The same by some effects.
    pub(crate) fn among<'a>(
        some: impl Iterator<Item = &'a Arc<dyn Effect>>,
        model: &Description,
        own: &[Arc<dyn Effect>],
        observations: &Observations,
    ) -> Result<Self, DiagnosisError> {
        let candidates = Candidates::among(some, model, own, observations)?;
        let of_push = push_directions(model)?;
        let directions: Vec<Direction> =
            of_push.iter().chain(&candidates.directions).cloned().collect();
        let linearisation = Linearisation::of(model, own, observations, &directions)?;
        Ok(Self { candidates, linearisation, n_of_push: of_push.len() })
    }

    /// Change of every step's numbers by the unit of a candidate's coordinate.
    pub(crate) fn slopes(&self, coordinate: usize) -> &[[f64; 7]] {
        &self.linearisation.slopes[self.n_of_push + coordinate]
    }
}
