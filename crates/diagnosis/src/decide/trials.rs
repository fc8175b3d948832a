//! The likeliest effects of a screen, each fitted beside a model.

use super::found::{Progress, Refused};
use super::phase::DiagnosePhase;
use super::rules::Objection;
use super::search::Search;
use super::tried::Tried;
use crate::cut_offs::{HINT, SIZE};
use crate::fit::Refit;
use crate::{DiagnosisError, Screen, ScreenedEffect};

/// Effects that are tried after a screen, the strongest first.
const MOST_TRIALS: usize = 6;
/// An effect whose score is a smaller share of the largest is not tried.
const LEAST_SHARE: f64 = 0.05;
/// Trials within this of the best, in units of the sum and as a share of the fall, go on to their
/// minimum.
const FINALIST: (f64, f64) = (50.0, 0.2);

impl Search<'_> {
    /// The likeliest effects of a screen beside those chosen, near their minima, the best first.
    pub(super) fn tried<'a>(
        &self,
        here: &Refit<'a>,
        screen: &Screen,
        progress: &mut Progress,
    ) -> Result<Vec<Tried<'a>>, DiagnosisError> {
        let mut tried = Vec::new();
        let worth = self.worth_a_trial(screen, progress);
        for (index, effect) in worth.iter().copied().enumerate() {
            self.tell(DiagnosePhase::Trying { effect, number: index + 1, of: worth.len() });
            tried.extend(self.try_one(here, effect, &mut progress.refused)?);
        }
        // Numbers left open may hide from a screen what explains as much as the best.
        let alike = self.alike_the_best(&tried, screen, progress);
        for (index, effect) in alike.iter().copied().enumerate() {
            let (number, of) = (worth.len() + index + 1, worth.len() + alike.len());
            self.tell(DiagnosePhase::Trying { effect, number, of });
            tried.extend(self.try_one(here, effect, &mut progress.refused)?);
        }
        let least = tried.iter().map(Tried::cost).fold(f64::INFINITY, f64::min);
        let near = FINALIST.0.max(FINALIST.1 * (here.objective() - least));
        let is_finalist = |one: &Tried| one.size >= SIZE && one.cost() < least + near;
        // A single one needs no exact comparison.
        let of = tried.iter().filter(|one| is_finalist(one)).count();
        let finalists = tried.iter_mut().filter(|one| of > 1 && is_finalist(one));
        for (index, one) in finalists.enumerate() {
            let effect = one.trial.id();
            self.tell(DiagnosePhase::Comparing { effect, number: index + 1, of });
            // Where the way ends early, what was reached counts.
            if one.trial.finish().is_ok() {
                one.size = one.without.as_ref().unwrap_or(here).size_of(&one.trial)?;
            }
        }
        tried.sort_by(|a, b| a.cost().total_cmp(&b.cost()));
        Ok(tried)
    }

    /// An effect near its minimum beside a model; none, and noted, where it cannot be predicted.
    pub(super) fn try_one<'a>(
        &self,
        here: &Refit<'a>,
        id: &'static str,
        refused: &mut Vec<Refused>,
    ) -> Result<Option<Tried<'a>>, DiagnosisError> {
        let Some(effect) = self.effect(id) else { return Ok(None) };
        let trial = match here.trial(effect) {
            Ok(trial) => trial,
            Err(why) => {
                let objection = Objection::Unsettled { why: why.to_string() };
                refused.push(Refused { id, objection });
                return Ok(None);
            }
        };
        let without = if here.has(id) { Some(here.without(&[id])?) } else { None };
        let size = without.as_ref().unwrap_or(here).size_of(&trial)?;
        Ok(Some(Tried { trial, without, size }))
    }

    /// The strongest effects of a screen, and what looks like the very strongest.
    fn worth_a_trial(&self, screen: &Screen, progress: &Progress) -> Vec<&'static str> {
        let may_be_tried = |effect: &&ScreenedEffect| {
            effect.not_testable.is_none()
                && !self.is_nominal(effect.id)
                && !progress.was_superfluous(effect.id)
                && effect.p_adjusted <= HINT
        };
        let sure: Vec<&ScreenedEffect> = screen.effects.iter().filter(may_be_tried).collect();
        // Not of numbers that every fit leaves open: these are not tried, however strong they are.
        let largest = sure.iter().map(|effect| effect.statistic).fold(0.0, f64::max);
        let is_worth = |effect: &&&ScreenedEffect| effect.statistic >= LEAST_SHARE * largest;
        let worth: Vec<&'static str> =
            sure.iter().filter(is_worth).map(|effect| effect.id).collect();
        let best = worth.first().copied().unwrap_or_default();
        let is_like_best = |id: &str| {
            let mut pairs = screen.look_alikes.iter();
            self.are_known_alike(best, id)
                || pairs.any(|pair| {
                    [pair.one, pair.other] == [best, id] || [pair.other, pair.one] == [best, id]
                })
        };
        let tried = worth.iter().enumerate();
        let tried = tried.filter(|(rank, id)| *rank < MOST_TRIALS || is_like_best(id));
        tried.map(|(_, id)| *id).collect()
    }
}
