//! Adding the best effect, as long as one obeys every rule.

use std::sync::Arc;

use effects::{Effect, Nuisance, by_id_with};
use models::Description;

use super::DiagnoseSettings;
use super::both_noises::BothNoises;
use super::found::{Choice, Found, Progress, Refused, ids};
use super::linearised::Linearised;
use super::phase::DiagnosePhase;
use super::rules::{Objection, Rules};
use super::tried::Tried;
use crate::cut_offs::{APART, HINT, MOST_SMALL, NAME, SIZE};
use crate::fit::Refit;
use crate::noise::widely_differing::At;
use crate::predict::candidates::follow_from_points;
use crate::{DiagnosisError, FitSettings, Observations, Screen};

/// The search on the pushes to fit to.
pub(super) struct Search<'a> {
    pub(super) model: &'a Description,
    pub(super) all: &'a Observations,
    pub(super) fitted: &'a Observations,
    /// Opened when the search is over.
    pub(super) aside: &'a Observations,
    pub(super) settings: &'a DiagnoseSettings,
    /// Hears what the search is at.
    pub(super) observer: &'a dyn Fn(DiagnosePhase),
    /// Whether it may go by what is expected of pushes that differ widely.
    pub(super) may_expect: bool,
}

/// Where a search goes on.
enum Next<'a> {
    /// To an effect and the model with it.
    Large(Box<(Choice, Refit<'a>)>),
    /// To what is sure and hardly seen among the effects that were tried, if anything is.
    Small { tried: Vec<Tried<'a>>, which: Vec<usize> },
}

/// An effect of which the quadratic at the minimum promises so many times [`APART`] is not what others explain.
const FAR_FROM_APART: f64 = 30.0;

impl Search<'_> {
    pub(super) fn run(&self) -> Result<Found, DiagnosisError> {
        let Linearised { usual, screen: first_screen, .. } =
            self.linearised(self.model, At::Middle)?;
        let settings = self.fit_settings();
        let here = Refit::new(self.fitted, self.model, &usual, &settings)?;
        self.forward_step(&here, Progress { first_screen, chosen: Vec::new(), refused: Vec::new() })
    }

    /// Adds one effect after the other to a model at its minimum. Each time the noise is learnt anew,
    /// for what alike pushes differ by is the less the model misses the surer noise; and its
    /// covariance is linearised anew, for pushes at the edge of sliding change sides.
    ///
    /// Between two such models noise is as large as is usual: one that was learnt beside what a model
    /// misses takes that for noise, and would keep the next model near the last.
    fn forward_step(&self, from: &Refit, mut progress: Progress) -> Result<Found, DiagnosisError> {
        let about = self.screened(from)?;
        let Linearised { noise, whitening, usual, screen } = self.linearised(&about, At::Middle)?;
        let here = from.rewhitened(&whitening)?;
        let both = BothNoises::new(&here, &usual);
        // What speaks of the support may be points in disguise, before others take up what it leaves.
        let is_of_support =
            progress.last_large().is_some_and(|id| follow_from_points().contains(&id));
        if is_of_support && let Some(there) = self.on_points(&both, &screen, &mut progress)? {
            return self.forward_step(&there, progress);
        }
        let is_full = progress.n_chosen(false) == self.settings.most_effects;
        let next = match is_full {
            true => Next::Small { tried: Vec::new(), which: Vec::new() },
            false => self.next(&here, &screen, &mut progress)?,
        };
        match next {
            Next::Large(found) => {
                let (choice, there) = *found;
                let there = self.with_choice(choice, there, &mut progress)?;
                // Where nothing settles then, the next model starts from here.
                let there = there.roughly_rewhitened(&usual).unwrap_or(there);
                self.forward_step(&there, progress)
            }
            // What is hardly seen comes last, and changes too little to be worth another screen.
            Next::Small { tried, which } => {
                if !is_of_support
                    && let Some(there) = self.on_points(&both, &screen, &mut progress)?
                {
                    return self.forward_step(&there, progress);
                }
                if !is_full && let Some(there) = self.on_few_steps(&both, &screen, &mut progress)? {
                    return self.forward_step(&there, progress);
                }
                let may_expect = self.may_expect && progress.n_chosen(false) == 0;
                if may_expect
                    && noise.is_wide_beside(&about)?
                    && let Some(found) = self.expecting()?
                {
                    return Ok(found);
                }
                let there = self.with_small(here, (tried, which), &screen, &mut progress)?;
                self.concluded(&there, progress, screen, (noise, At::Middle))
            }
        }
    }

    /// What is found beside the model under test where pushes differ widely, and it is fitted to what is expected of
    /// them; none where that lets an effect seem large which the model of a push in the middle of all does not miss.
    ///
    /// What a model lacks lets pushes seem to differ widely: an effect is looked for at the middle first.
    fn expecting(&self) -> Result<Option<Found>, DiagnosisError> {
        let Linearised { usual, screen: first_screen, .. } =
            self.linearised(self.model, At::Expected)?;
        let from = Refit::new(self.fitted, self.model, &usual, &self.fit_settings())?;
        let about = self.screened(&from)?;
        let Linearised { noise, whitening, screen, .. } = self.linearised(&about, At::Expected)?;
        let here = from.rewhitened(&whitening)?;
        let mut progress = Progress { first_screen, chosen: Vec::new(), refused: Vec::new() };
        let Next::Small { tried, which } = self.next(&here, &screen, &mut progress)? else {
            return Ok(None);
        };
        let there = self.with_small(here, (tried, which), &screen, &mut progress)?;
        self.concluded(&there, progress, screen, (noise, At::Expected)).map(Some)
    }

    fn linearised(&self, about: &Description, at: At) -> Result<Linearised, DiagnosisError> {
        Linearised::of(about, at, self.fitted, self.settings, self.observer)
    }

    /// The best effect beside those chosen that obeys every rule; notes those that do not.
    fn next<'a>(
        &self,
        here: &Refit<'a>,
        screen: &Screen,
        progress: &mut Progress,
    ) -> Result<Next<'a>, DiagnosisError> {
        let gain_so_far = gain_so_far(here, progress)?;
        let rules = Rules { gain_so_far, is_first: progress.n_chosen(false) == 0 };
        let tried = self.tried(here, screen, progress)?;
        let noted = progress.refused.len();
        let next = self.best(here, screen, (&rules, tried), progress)?;
        let Next::Small { mut tried, which } = next else { return Ok(next) };
        if !Self::look_farther(here, screen, &mut tried)? {
            return Ok(Next::Small { tried, which });
        }
        progress.refused.truncate(noted);
        self.best(here, screen, (&rules, tried), progress)
    }

    /// Looks farther where what is sure seemed hardly seen; tells whether any is large there.
    fn look_farther(
        here: &Refit,
        screen: &Screen,
        tried: &mut [Tried],
    ) -> Result<bool, DiagnosisError> {
        let is_small = |one: &&mut Tried| one.size < SIZE && screen.p_of(one.trial.id()) <= NAME;
        let mut small = tried.iter_mut().filter(is_small);
        let is_any = small.try_fold(false, |is_any, one| Ok(one.goes_farther(here)? || is_any));
        tried.sort_by(|a, b| a.cost().total_cmp(&b.cost()));
        is_any
    }

    /// The best of what was tried that obeys every rule; notes what does not.
    fn best<'a>(
        &self,
        here: &Refit<'a>,
        screen: &Screen,
        (rules, tried): (&Rules, Vec<Tried<'a>>),
        progress: &mut Progress,
    ) -> Result<Next<'a>, DiagnosisError> {
        let mut which = Vec::new();
        for (index, Tried { trial, without, size }) in tried.iter().enumerate() {
            let id = trial.id();
            let p_adjusted = screen.p_of(id);
            let gain = without.as_ref().unwrap_or(here).misfit_by(here) - trial.objective();
            let objection = match rules.objection(p_adjusted, gain, *size) {
                None => match self.chosen(here, &tried, index)? {
                    Ok((rivals, there)) => {
                        let choice = Choice { id, p_adjusted, rivals, is_small: false };
                        return Ok(Next::Large(Box::new((choice, there))));
                    }
                    Err(objection) => objection,
                },
                Some(objection) => objection,
            };
            // One of a group is no second effect beside another of it.
            let is_rival = progress.chosen.iter().any(|one| one.rivals.contains(&id));
            if matches!(objection, Objection::Small { .. }) && p_adjusted <= NAME && !is_rival {
                which.push(index);
            }
            // What no screen saw was tried as a rival alone.
            if p_adjusted <= HINT {
                progress.refused.push(Refused { id, objection });
            }
        }
        Ok(Next::Small { tried, which })
    }

    /// The model with what is hardly seen, the best first.
    fn with_small<'a>(
        &self,
        mut here: Refit<'a>,
        (mut tried, mut which): (Vec<Tried<'a>>, Vec<usize>),
        screen: &Screen,
        progress: &mut Progress,
    ) -> Result<Refit<'a>, DiagnosisError> {
        while progress.n_chosen(true) < MOST_SMALL {
            let mut found = None;
            while let (None, Some(index)) = (&found, which.first().copied()) {
                which.remove(0);
                let id = tried[index].trial.id();
                let with = self.chosen(&here, &tried, index)?.ok();
                found = with.map(|(rivals, there)| {
                    let p_adjusted = screen.p_of(id);
                    (Choice { id, p_adjusted, rivals, is_small: true }, there)
                });
            }
            let Some((choice, there)) = found else { break };
            let others = which.iter().map(|index| tried[*index].trial.id());
            let others: Vec<_> = others.filter(|id| !choice.rivals.contains(id)).collect();
            here = self.with_choice(choice, there, progress)?;
            let of = others.len();
            let beside = others.into_iter().enumerate().map(|(index, effect)| {
                self.tell(DiagnosePhase::Trying { effect, number: index + 1, of });
                self.try_one(&here, effect, &mut progress.refused)
            });
            tried = beside.filter_map(Result::transpose).collect::<Result<_, _>>()?;
            which = (0..tried.len()).collect();
        }
        Ok(here)
    }

    /// The model with one effect more, without those that it explains, too.
    pub(super) fn with_choice<'a>(
        &self,
        choice: Choice,
        there: Refit<'a>,
        progress: &mut Progress,
    ) -> Result<Refit<'a>, DiagnosisError> {
        progress.refused.retain(|one| one.id != choice.id);
        progress.chosen.push(choice);
        self.without_superfluous(there, progress)
    }

    /// The model with an effect at its minimum, and what explains as much; or what speaks against it.
    fn chosen<'a>(
        &self,
        here: &Refit<'a>,
        tried: &[Tried<'a>],
        index: usize,
    ) -> Result<Result<(Vec<&'static str>, Refit<'a>), Objection>, DiagnosisError> {
        let Tried { trial, without, .. } = &tried[index];
        self.tell(DiagnosePhase::Refitting { effect: trial.id() });
        let there = match here.with(trial).and_then(|there| self.told_everywhere(there)) {
            Ok(there) => there,
            // An effect whose refit does not settle, or tells some push nothing, is no explanation.
            Err(why) => return Ok(Err(Objection::Unsettled { why: why.to_string() })),
        };
        let without = without.as_ref().unwrap_or(here);
        if let Some(objection) = self.objection_to(without, &there, trial.id())? {
            return Ok(Err(objection));
        }
        Ok(Ok((self.rivals(tried, index, here, &there)?, there)))
    }

    /// What speaks against an effect by its estimate and by what it predicts.
    fn objection_to(
        &self,
        here: &Refit,
        there: &Refit,
        id: &str,
    ) -> Result<Option<Objection>, DiagnosisError> {
        let fit = match there.fit(&self.fit_settings()) {
            Err(why @ DiagnosisError::OneCluster { .. }) => return Ok(Some(why.into())),
            fit => fit?,
        };
        let objection = Rules::objection_to(&fit, id, self.tolerance(id));
        let left_out = || [here.left_out(there), there.left_out(there)];
        Ok(objection.or_else(|| Rules::objection_to_gain(self.fitted, left_out())))
    }

    /// Whether every fit leaves the effect's numbers open without any prior.
    pub(super) fn is_nominal(&self, id: &str) -> bool {
        self.tolerance(id) == Some(f64::INFINITY)
    }

    /// The standard error with which an effect is a nuisance; none if it is not one.
    fn tolerance(&self, id: &str) -> Option<f64> {
        self.settings.screen.tolerances.of(self.effect(id)?.info())
    }

    /// How far a number that every fit leaves open may be off, as a share of its nominal value.
    pub(super) fn nominal_within(&self, id: &str) -> Option<f64> {
        match self.effect(id)?.info().nuisance {
            Nuisance::Free { nominal_within } => Some(nominal_within),
            Nuisance::No | Nuisance::Known(_) => None,
        }
    }

    /// A model without the effects that the last one explains, too.
    pub(super) fn without_superfluous<'a>(
        &self,
        there: Refit<'a>,
        progress: &mut Progress,
    ) -> Result<Refit<'a>, DiagnosisError> {
        let last = progress.chosen.len() - 1;
        for id in ids(&progress.chosen[..last]) {
            if there.promised_without(id) > FAR_FROM_APART * APART * there.scale().powi(2) {
                continue;
            }
            let without = there.briefly_without(&[id])?;
            if without.misfit_by(&there) - there.objective() < APART * there.scale().powi(2) {
                progress.chosen.retain(|one| one.id != id);
                progress.refused.push(Refused { id, objection: Objection::Superfluous });
                return Ok(without);
            }
        }
        // What is hardly seen tells no groups apart.
        if progress.chosen[last].is_small {
            return Ok(there);
        }
        Ok(self.with_a_rival(there, progress))
    }

    /// The model at its minimum as a screen takes it: what is known beforehand of small nuisances
    /// stays what it was.
    fn screened(&self, here: &Refit) -> Result<Description, DiagnosisError> {
        let [asked, mut whole] = here.descriptions()?;
        let is_bounded = |id: &str| self.tolerance(id).is_some_and(f64::is_finite);
        whole.effects.retain(|effect| {
            let is_asked = asked.effects.iter().any(|other| other.id == effect.id);
            is_asked || !is_bounded(&effect.id)
        });
        Ok(whole)
    }

    pub(super) fn fit_settings(&self) -> FitSettings {
        let (own, tolerances) = (self.settings.own.clone(), self.settings.screen.tolerances);
        FitSettings { own, tolerances, resemblances: false, ..FitSettings::default() }
    }

    pub(super) fn tell(&self, phase: DiagnosePhase) {
        (self.observer)(phase);
    }

    pub(super) fn effect(&self, id: &str) -> Option<&Arc<dyn Effect>> {
        by_id_with(id, &self.settings.own).ok()
    }
}

/// What all that were chosen take off the sum, under the covariance and with the thresholds of now.
fn gain_so_far(here: &Refit, progress: &Progress) -> Result<f64, DiagnosisError> {
    if progress.chosen.is_empty() {
        return Ok(0.0);
    }
    Ok(here.briefly_without(&ids(&progress.chosen))?.misfit_by(here) - here.objective())
}
