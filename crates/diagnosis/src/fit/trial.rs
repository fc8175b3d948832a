//! One more effect beside a model at its minimum.

use std::sync::Arc;

use effects::Effect;
use nalgebra::DMatrix;

use super::Refit;
use super::descent::{BRIEF, Exactness, Minimum, Start};
use super::problem::{Evaluation, Problem};
use crate::DiagnosisError;

/// One more effect beside a fitted model, near the minimum of both.
#[derive(Clone, Debug)]
pub(crate) struct Trial<'a> {
    pub(crate) effect: Arc<dyn Effect>,
    /// Numbers in which it is moved.
    pub(crate) freedom: usize,
    problem: Problem<'a>,
    minimum: Minimum,
}

impl<'a> Refit<'a> {
    /// Goes some way down with one more effect, from "off" and from the best of its typical sizes if
    /// that is better than "off": where pushes come to slide or to stick the sum may rise before it falls.
    ///
    /// The weights stay those of the model without it, so falls of the sum can be compared.
    ///
    /// # Errors
    /// What a prediction refuses.
    pub(crate) fn trial(&self, effect: &Arc<dyn Effect>) -> Result<Trial<'a>, DiagnosisError> {
        let Problem { space, whitening, robust, .. } = &self.problem;
        let mut problem = Problem::new(space.with(effect)?, whitening, robust.clone());
        let numbers = problem.space.numbers_of(effect.info().id).unwrap_or(0..0);
        // What was taken out stays out.
        for (k, frozen) in self.problem.frozen.iter().enumerate() {
            problem.frozen[k] |= *frozen && !numbers.contains(&k);
        }
        let mut x = self.minimum.at.x.clone();
        for member in problem.space.members.iter().skip(space.members.len()) {
            x.extend(member.place(&member.off));
        }
        let switched = problem.switched_on(&x);
        numbers.clone().for_each(|k| x[k] = switched[k]);
        let at = problem.stand(x)?;
        let mut own = problem.clone();
        own.frozen.iter_mut().enumerate().for_each(|(k, frozen)| *frozen |= !numbers.contains(&k));
        let of_effect = own.slopes(&at, &own.secants)?;
        let (columns, known) = (problem.moved(), self.problem.moved());
        let mut slopes = DMatrix::zeros(at.z.len(), columns.len());
        for (column, k) in columns.iter().enumerate() {
            let of_own = own.moved().iter().position(|other| other == k);
            let of_known = || known.iter().position(|other| other == k);
            let source = of_own
                .map(|place| of_effect.column(place))
                .or_else(|| Some(self.minimum.whole.column(of_known()?)));
            // A number that moves is the effect's or was moved before.
            if let Some(source) = source {
                slopes.view_mut((0, column), (source.len(), 1)).copy_from(&source);
            }
        }
        let freedom = own.moved().len().max(1);
        let start = Start { at, slopes: Some(slopes), exactness: Exactness::Rough };
        let Start { at: off, slopes, .. } = &start;
        let far = problem.farther(off.clone(), numbers.clone());
        let far = (far.x != off.x).then(|| {
            let slopes = slopes.as_ref().map(|slopes| problem.carried(slopes.clone(), off, &far));
            Start { at: far, slopes, exactness: Exactness::Rough }
        });
        let unseen = own.moved().into_iter().zip(of_effect.column_iter());
        // Below the pushes' rows stand those of priors.
        let n_rows = whitening.rows().last().map_or(0, |rows| rows.end);
        let unseen = unseen.filter(|(_, slopes)| slopes.rows(0, n_rows).amax() == 0.0);
        let unseen: Vec<usize> = unseen.map(|(k, _)| k).collect();
        let mut minimum = problem.descend_briefly(start, BRIEF)?;
        let is_far = far.is_some();
        if let Some(far) = far
            && let Ok(other) = problem.descend_briefly(far, BRIEF)
            && other.at.value < minimum.at.value
        {
            minimum = other;
        }
        // What shows nothing at "off", as the speed over which nothing fades, shows something here.
        if !unseen.is_empty() {
            let Minimum { at, whole, .. } = minimum;
            minimum = problem.descend_knowing(&unseen, (at, whole))?;
        }
        while is_far && let Some(stair) = problem.next_stair(&minimum.at, numbers.clone()) {
            let slopes = problem.carried(minimum.whole.clone(), &minimum.at, &stair);
            let start = Start { at: stair, slopes: Some(slopes), exactness: Exactness::Rough };
            // Where the way from there is none, what was reached counts.
            let Ok(lower) = problem.descend_briefly(start, BRIEF) else { break };
            minimum = lower;
        }
        Ok(Trial { effect: effect.clone(), freedom, problem, minimum })
    }

    /// The minimum with one more effect from the best of its typical sizes; none where "off" is better than all.
    ///
    /// # Errors
    /// What a prediction refuses; as a descent.
    pub(crate) fn far_from_off(
        &self,
        effect: &Arc<dyn Effect>,
    ) -> Result<Option<Self>, DiagnosisError> {
        let trial = self.trial(effect)?;
        match trial.objective() < self.objective() {
            true => Ok(Some(self.with(&trial)?)),
            false => Ok(None),
        }
    }

    /// The minimum with the effect of a trial.
    ///
    /// # Errors
    /// As a descent.
    pub(crate) fn with(&self, trial: &Trial<'a>) -> Result<Self, DiagnosisError> {
        let mut problem = trial.problem.clone();
        let Minimum { at, whole, .. } = &trial.minimum;
        let minimum = problem.settle(at.x.clone(), Some(whole.clone()), Exactness::Sum)?;
        let (before, dropped) = (self.minimum.clone(), self.dropped.clone());
        Ok(Self { problem, minimum, before, dropped, ..*self })
    }

    /// What a trial changes in the number that it changes most, over the noise.
    ///
    /// # Errors
    /// What a prediction refuses.
    pub(crate) fn size_of(&self, trial: &Trial) -> Result<f64, DiagnosisError> {
        let there = trial.problem.space.residuals(&trial.minimum.at.x)?;
        Ok(self.difference(&self.problem.space.residuals(&self.minimum.at.x)?, &there))
    }
}

impl Problem<'_> {
    /// A minimum near a place at which slopes are known but for those along some numbers.
    fn descend_knowing(
        &self,
        unknown: &[usize],
        (at, mut slopes): (Evaluation, DMatrix<f64>),
    ) -> Result<Minimum, DiagnosisError> {
        let mut alone = self.clone();
        alone
            .frozen
            .iter_mut()
            .enumerate()
            .for_each(|(k, frozen)| *frozen |= !unknown.contains(&k));
        let found = alone.slopes(&at, &alone.secants)?;
        let moved = self.moved();
        for (k, column) in alone.moved().iter().zip(found.column_iter()) {
            if let Some(place) = moved.iter().position(|other| other == k) {
                slopes.set_column(place, &column);
            }
        }
        let start = Start { at, slopes: Some(slopes), exactness: Exactness::Rough };
        self.descend_briefly(start, BRIEF)
    }

    /// A minimum near a place from which `others` moves first, by the slopes of a minimum.
    fn beside_others(
        &self,
        others: &Self,
        minimum: &Minimum,
        x: Vec<f64>,
    ) -> Result<Minimum, DiagnosisError> {
        let (moved, known) = (self.moved(), others.moved());
        let columns = known.iter().filter_map(|k| moved.iter().position(|other| other == k));
        let columns: Vec<usize> = columns.collect();
        let slopes = Some(minimum.whole.select_columns(&columns));
        let start = Start { at: others.stand(x)?, slopes, exactness: Exactness::Rough };
        let Minimum { at, whole, .. } = others.descend_briefly(start, BRIEF)?;
        let mut slopes = minimum.whole.clone();
        for (place, column) in columns.iter().zip(whole.column_iter()) {
            slopes.set_column(*place, &column);
        }
        let own: Vec<usize> = moved.into_iter().filter(|k| !known.contains(k)).collect();
        self.descend_knowing(&own, (at, slopes))
    }
}

impl Trial<'_> {
    /// The effect's numbers near the minimum.
    #[cfg(test)]
    fn numbers(&self) -> Vec<f64> {
        let numbers = self.problem.space.numbers_of(self.id()).unwrap_or(0..0);
        self.minimum.at.x[numbers].to_vec()
    }

    pub(crate) fn id(&self) -> &'static str {
        self.effect.info().id
    }

    /// What is minimised, with the thresholds of the model that was tried.
    pub(crate) fn objective(&self) -> f64 {
        self.minimum.at.value
    }

    /// As [`Refit::misfit_by`].
    pub(crate) fn misfit_by(&self, other: &Refit) -> f64 {
        other.problem.robust.value(&self.minimum.at.z)
    }

    /// Looks for a lower minimum from the effect's typical sizes to either side, to each of which all else
    /// is fitted first.
    ///
    /// A number left open may hold the model where most pushes go right and some far wrong: there friction
    /// that suits one side of the pusher, and of which no other size is better by itself.
    pub(crate) fn look_farther(&mut self) {
        let numbers = self.problem.space.numbers_of(self.id()).unwrap_or(0..0);
        let mut others = self.problem.clone();
        others.frozen[numbers.clone()].fill(true);
        let off = self.minimum.clone();
        for k in numbers.filter(|k| !self.problem.frozen[*k]) {
            for x in self.problem.typical_sizes(&off.at.x, k) {
                // A size that the mechanics refuse is no start.
                let Ok(found) = self.problem.beside_others(&others, &off, x) else { continue };
                if found.at.value < self.minimum.at.value {
                    self.minimum = found;
                }
            }
        }
    }

    /// Goes on to where the sum falls no more, with the same weights.
    ///
    /// # Errors
    /// As a descent.
    pub(crate) fn finish(&mut self) -> Result<(), DiagnosisError> {
        let Minimum { at, whole, .. } = self.minimum.clone();
        let start = Start { at, slopes: Some(whole), exactness: Exactness::Sum };
        self.minimum = self.problem.descend(start)?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use effects::by_id;

    use crate::FitSettings;
    use crate::fit::Refit;
    use crate::synthetic::{pushed_with, white};

    #[test]
    fn a_trial_finds_the_speed_over_which_stiction_fades_though_none_shows_it_at_first() {
        let (id, truth) = ("support-stiction", [1.3, 0.03]);
        let (observations, model, _) = pushed_with((id, &truth), 3);
        let whitening = white(&observations);
        let here = Refit::new(&observations, &model, &whitening, &FitSettings::default()).unwrap();
        let found = here.trial(by_id(id).unwrap()).unwrap().numbers();
        // It begins at 0.02 m/s.
        assert!((found[1] / truth[1] - 1.0).abs() < 0.1, "{found:?}");
        assert!((found[0] - truth[0]).abs() < 0.05, "{found:?}");
    }
}
