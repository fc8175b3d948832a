//! Predictions with the slopes of everything that may move them.

use std::sync::Arc;

use effects::{Effect, FrictionField, SupportPoints, all, tested};
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
    /// At a model, by the effects that a diagnosis tests; `own` are effects besides those of the catalogue.
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

    /// The same by every effect, but those of many numbers, which would take what is anything else's, where the
    /// model has them.
    ///
    /// # Errors
    /// As [`Tangent::of`].
    pub(crate) fn of_all(
        model: &Description,
        own: &[Arc<dyn Effect>],
        observations: &Observations,
    ) -> Result<Self, DiagnosisError> {
        let many = [SupportPoints.info().id, FrictionField.info().id];
        let has = |id: &str| model.effects.iter().any(|effect| effect.id == id);
        let is_told = |id: &str| !many.contains(&id) || has(id);
        let known = all().iter().filter(|effect| is_told(effect.info().id));
        Self::among(known.chain(own), model, own, observations)
    }

    /// That of every effect as [`Tangent::of`] gives it.
    pub(crate) fn of_tested(&self, own: &[Arc<dyn Effect>]) -> Self {
        let is_tested = |id: &str| tested().iter().chain(own).any(|one| one.info().id == id);
        let (candidates, kept) = self.candidates.only(is_tested);
        let kept = kept.into_iter().map(|coordinate| self.n_of_push + coordinate);
        let directions: Vec<usize> = (0..self.n_of_push).chain(kept).collect();
        Self { candidates, linearisation: self.linearisation.only(&directions), ..*self }
    }

    fn among<'a>(
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

#[cfg(test)]
mod tests {
    use super::Tangent;
    use crate::synthetic::pushed_with;

    #[test]
    fn the_tangent_by_every_effect_holds_that_by_the_tested_ones() {
        let (observations, model, _) = pushed_with(("table-tilt", &[0.2, 0.1]), 1);
        let all = Tangent::of_all(&model, &[], &observations).unwrap();
        let tested = Tangent::of(&model, &[], &observations).unwrap();
        assert!(all.candidates.effects.len() > tested.candidates.effects.len());
        let found = all.of_tested(&[]);
        assert_eq!(found.candidates.names, tested.candidates.names);
        assert_eq!(found.candidates.off, tested.candidates.off);
        let coordinates = |of: &Tangent| -> Vec<_> {
            of.candidates.effects.iter().map(|one| one.coordinates.clone()).collect()
        };
        assert_eq!(coordinates(&found), coordinates(&tested));
        assert_eq!(found.linearisation.slopes, tested.linearisation.slopes);
        assert_eq!(found.linearisation.bends, tested.linearisation.bends);
        assert_eq!(found.linearisation.rooms, tested.linearisation.rooms);
    }
}
