//! Effects that explain as much as the best one.

use super::found::{Choice, Progress, Refused, ids};
use super::rules::Objection;
use super::search::Search;
use super::tried::Tried;
use crate::cut_offs::{APART, OWN_SHARE, SHARE_APART, SIZE};
use crate::fit::Refit;
use crate::{DiagnosisError, Screen};

impl Search<'_> {
    /// Effects that explain nearly as much as one of those tried: within [`APART`] in twice the
    /// log likelihood; of confounders within a share of what it explains, for a model of a rig
    /// is not true enough to tell them apart by less.
    ///
    /// All is measured from the model `here`, whose small nuisances take what they can for themselves.
    /// What still explains half as much beside the one that was added is another effect, not a rival.
    pub(super) fn rivals(
        &self,
        tried: &[Tried],
        best: usize,
        here: &Refit,
        there: &Refit,
    ) -> Result<Vec<&'static str>, DiagnosisError> {
        let (winner, apart) = (&tried[best].trial, APART * there.scale().powi(2));
        let of_alike = SHARE_APART * (here.objective() - winner.objective());
        let mut rivals = Vec::new();
        for (index, Tried { trial: other, .. }) in tried.iter().enumerate() {
            let bound = match self.are_known_alike(winner.id(), other.id()) {
                true => apart.max(of_alike),
                false => apart,
            };
            if index == best || other.objective() >= winner.objective() + bound {
                continue;
            }
            let alone = here.misfit_by(there) - other.misfit_by(there);
            // What cannot be predicted beside the winner is no second effect.
            let beside =
                there.trial(&other.effect).map_or(0.0, |both| there.objective() - both.objective());
            if beside < OWN_SHARE * alone {
                rivals.push(other.id());
            }
        }
        Ok(rivals)
    }

    /// Whether one of two effects is documented to look like the other.
    pub(super) fn are_known_alike(&self, one: &str, other: &str) -> bool {
        let names = |id: &str, other: &str| {
            let about = self.effect(id).map(|effect| effect.info());
            about.is_some_and(|about| about.confounders.iter().any(|alike| alike.id == other))
        };
        names(one, other) || names(other, one)
    }

    /// Confounders of the best effect tried that were not tried themselves.
    pub(super) fn alike_the_best(
        &self,
        tried: &[Tried],
        screen: &Screen,
        progress: &Progress,
    ) -> Vec<&'static str> {
        let large = tried.iter().filter(|one| one.size >= SIZE);
        let Some(best) = large.min_by(|a, b| a.cost().total_cmp(&b.cost())) else {
            return Vec::new();
        };
        let is_new = |id: &str| {
            !tried.iter().any(|one| one.trial.id() == id)
                && !progress.chosen.iter().any(|one| one.id == id)
                && !progress.was_superfluous(id)
        };
        let testable = screen.effects.iter().filter(|effect| effect.not_testable.is_none());
        let alike = testable.map(|effect| effect.id).filter(|id| {
            is_new(id) && !self.is_nominal(id) && self.are_known_alike(best.trial.id(), id)
        });
        alike.collect()
    }

    /// A model with a rival of the last effect that does without an earlier one, if there is one.
    pub(super) fn with_a_rival<'a>(&self, there: Refit<'a>, progress: &mut Progress) -> Refit<'a> {
        let most = there.objective() + APART * there.scale().powi(2);
        let last = progress.chosen.len() - 1;
        let Choice { id: last_id, rivals, p_adjusted, is_small } = progress.chosen[last].clone();
        for id in ids(&progress.chosen[..last]) {
            let mut alone: Vec<(&'static str, Refit<'a>)> = Vec::new();
            for rival in &rivals {
                // A rival that does not settle explains nothing.
                let without = self.with_instead(&there, last_id, rival);
                let without = without.and_then(|other| other.briefly_without(&[id]).ok());
                alone.extend(without.filter(|m| m.misfit_by(&there) < most).map(|m| (*rival, m)));
            }
            let by_misfit = |m: &Refit| m.misfit_by(&there);
            alone.sort_by(|a, b| by_misfit(&a.1).total_cmp(&by_misfit(&b.1)));
            let also: Vec<&'static str> = alone.iter().skip(1).map(|one| one.0).collect();
            if let Some((rival, model)) = alone.into_iter().next() {
                progress.chosen.retain(|one| ![id, last_id].contains(&one.id));
                progress.chosen.push(Choice { id: rival, p_adjusted, rivals: also, is_small });
                for id in [id, last_id] {
                    progress.refused.push(Refused { id, objection: Objection::Superfluous });
                }
                return model;
            }
        }
        there
    }

    /// A model with one effect in the place of another; none where it does not settle.
    pub(super) fn with_instead<'a>(
        &self,
        model: &Refit<'a>,
        id: &'static str,
        other: &'static str,
    ) -> Option<Refit<'a>> {
        let effect = self.effect(other)?;
        model.without(&[id]).and_then(|without| without.with(&without.trial(effect)?)).ok()
    }
}
