//! A model at its minimum, with where the object rests in the place of numbers that follow from it.

use std::sync::Arc;

use effects::Effect;

use super::Refit;
use super::descent::Exactness;
use super::problem::Problem;
use crate::DiagnosisError;

impl<'a> Refit<'a> {
    /// The minimum with an effect that says where the object rests, from where the motions say that it does;
    /// effects in `instead` are off.
    ///
    /// # Errors
    /// As a descent.
    pub(crate) fn borne_by(
        &self,
        effect: &Arc<dyn Effect>,
        instead: &[&'static str],
    ) -> Result<Self, DiagnosisError> {
        let Problem { space, whitening, robust, .. } = &self.problem;
        let mut problem = Problem::new(space.with(effect)?, whitening, robust.clone());
        for (k, frozen) in self.problem.frozen.iter().enumerate() {
            problem.frozen[k] |= *frozen;
        }
        let follows: Vec<&'static str> =
            instead.iter().copied().filter(|id| self.has(id)).collect();
        for own in follows.iter().filter_map(|id| problem.space.numbers_of(id)) {
            problem.frozen[own].fill(true);
        }
        let mut x = self.place_with(|id| follows.contains(&id), |member| member.off.clone());
        for member in problem.space.members.iter().skip(space.members.len()) {
            x.extend(member.place(&member.start));
        }
        let mut there = self.clone();
        there.minimum = problem.settle(x, None, Exactness::Mixture)?;
        there.before = self.minimum.clone();
        there.problem = problem;
        there.dropped.extend(follows);
        Ok(there)
    }
}
