//! The end of a search: wrong nominal numbers, and what the held-out pushes confirm.

use models::Description;

use super::ErrorFall;
use super::confirmation::{Aside, Outcome};
use super::constancy::varies;
use super::found::{Accepted, Choice, Found, Progress, Refused, ids};
use super::phase::DiagnosePhase;
use super::raised::Raised;
use super::rules::{Objection, Rules, p_of_number};
use super::search::Search;
use crate::cut_offs::{HINT, NAME, SIZE, SMALL_SHARE, TOLERANCES};
use crate::fit::Refit;
use crate::noise::widely_differing::At;
use crate::{
    DiagnosisError, EffectFit, Fit, Gain, NoiseModel, NotTestable, NuisanceFit, Predictions,
    Reason, Screen, Undetermined,
};

impl Search<'_> {
    /// Adds the nominal numbers that the best model does not leave at their values, takes out what
    /// has no interval, and then what the held-out pushes do not confirm.
    ///
    /// Nominal numbers are left open in every fit, so no effect is blamed for them; here they are
    /// asked for.
    pub(super) fn concluded(
        &self,
        here: &Refit,
        mut progress: Progress,
        last_screen: Screen,
        (noise, at): (NoiseModel, At),
    ) -> Result<Found, DiagnosisError> {
        self.tell(DiagnosePhase::Intervals);
        // What the last model explains is no hint any more.
        let is_explained =
            |id: &str| last_screen.effects.iter().any(|one| one.id == id && one.p_adjusted > HINT);
        progress.refused.retain(|one| !one.objection.is_hint() || !is_explained(one.id));
        let numbers = self.wrong_numbers(here, &mut progress)?;
        // Their probability is known once they are asked for.
        let as_choice =
            |id: &&'static str| Choice { id, p_adjusted: 1.0, rivals: Vec::new(), is_small: false };
        progress.chosen.splice(..0, numbers.iter().map(as_choice));
        let whole = here.asking(&ids(&progress.chosen)).settled()?;
        let (whole, fit) = self.without_open(whole, &mut progress)?;
        let confirmed = self.confirmed(whole, fit, &mut progress, (&noise, at))?;
        let Confirmed { accepted, error, raised, descriptions, with_doubted } = confirmed;
        let [description, with_nuisances] = descriptions;
        let Progress { refused, first_screen, .. } = progress;
        Ok(Found {
            first_screen,
            last_screen,
            accepted,
            refused,
            noise,
            at,
            error,
            raised,
            description,
            with_nuisances,
            with_doubted,
        })
    }

    /// Nominal numbers that are off by more than their tolerance and matter, whichever effect of a
    /// group is the one.
    fn wrong_numbers(
        &self,
        here: &Refit,
        progress: &mut Progress,
    ) -> Result<Vec<&'static str>, DiagnosisError> {
        let settings = self.fit_settings();
        // Later screens are of models that carry some of the numbers, and do not test those. What is within
        // the noise of the model under test is seen beside one that misses less.
        let screened = &progress.first_screen.effects;
        let hides = |why: &NotTestable| why.reason != Reason::Weak;
        let is_hidden = |id: &str| {
            screened.iter().any(|one| one.id == id && one.not_testable.as_ref().is_some_and(hides))
        };
        let is_asked = |nuisance: &NuisanceFit| self.is_wrong(nuisance) && !is_hidden(nuisance.id);
        let wrong: Vec<NuisanceFit> =
            here.fit(&settings)?.nuisances.into_iter().filter(is_asked).collect();
        let others = if wrong.is_empty() { Vec::new() } else { self.beside_rivals(here, progress) };
        let mut claimed = Vec::new();
        for nuisance in wrong {
            let id = nuisance.id;
            let is_right_beside = |one: &&(&'static str, Vec<&'static str>)| !one.1.contains(&id);
            let size = here.size_against(id, &[nuisance.nominal])?;
            let objection = if size < SIZE {
                Some(Objection::Small { size })
            } else if is_mean_friction(here, &nuisance) {
                Some(Objection::MeanFriction)
            } else {
                let right = others.iter().find(is_right_beside);
                right.map(|(rival, _)| Objection::RightBeside { rival })
            };
            match objection {
                Some(objection) => progress.refused.push(Refused { id, objection }),
                None => claimed.push(id),
            }
        }
        Ok(claimed)
    }

    /// The nominal numbers that are wrong with each other effect of a group in the place of the best.
    fn beside_rivals(
        &self,
        here: &Refit,
        progress: &Progress,
    ) -> Vec<(&'static str, Vec<&'static str>)> {
        let mut found = Vec::new();
        for choice in &progress.chosen {
            for rival in &choice.rivals {
                let Some(there) = self.with_instead(here, choice.id, rival) else { continue };
                let Ok(fit) = there.fit(&self.fit_settings()) else { continue };
                let wrong = fit.nuisances.iter().filter(|one| self.is_wrong(one));
                found.push((*rival, wrong.map(|one| one.id).collect()));
            }
        }
        found
    }

    /// The fit with intervals, without effects that it leaves open and nominal numbers that it does not
    /// make sure.
    fn without_open<'a>(
        &self,
        mut whole: Refit<'a>,
        progress: &mut Progress,
    ) -> Result<(Refit<'a>, Fit), DiagnosisError> {
        loop {
            let fit = whole.fit(&self.fit_settings())?;
            let objection = open(&fit, &progress.chosen);
            let objection = objection.or_else(|| self.unsure_number(&fit, progress));
            let Some((id, objection)) = objection else {
                return Ok((whole, fit));
            };
            progress.chosen.retain(|one| one.id != id);
            progress.refused.push(Refused { id, objection });
            whole = self.not_asking(whole, id)?;
        }
    }

    /// The fit without an effect; a nominal number is left open as before it was asked for.
    fn not_asking<'a>(
        &self,
        whole: Refit<'a>,
        id: &'static str,
    ) -> Result<Refit<'a>, DiagnosisError> {
        match self.is_nominal(id) {
            true => Ok(whole.not_asking(id)),
            false => whole.without(&[id]),
        }
    }

    /// The gain of each cluster, left out of a fit or held out.
    fn gain(
        &self,
        (without, with): (&Refit, &Refit),
        held_out: Vec<f64>,
    ) -> Result<Gain, DiagnosisError> {
        match self.left_out(without, with) {
            // Of what rests on one cluster those held out decide alone.
            Err(DiagnosisError::OneCluster { .. }) => Ok(Gain::of(&held_out)),
            gains => Ok(Gain::of(&[gains?, held_out].concat())),
        }
    }

    /// An effect as fitted, with what it gains and the errors before, after and without it.
    fn accepted(
        &self,
        choice: &Choice,
        effect: EffectFit,
        (whole, screen): (&Refit, &Screen),
        (gain, [before, after, without]): (Gain, [&Outcome; 3]),
    ) -> Accepted {
        let id = choice.id;
        let raised = Raised::of(&without.missed, &after.missed);
        let [before, after, without] = [before, after, without].map(Outcome::rms);
        let p_adjusted = match self.nominal_within(id).is_some() {
            true => p_of_number(&effect, screen),
            false => choice.p_adjusted,
        };
        Accepted {
            id,
            p_adjusted,
            rivals: choice.rivals.clone(),
            effect,
            gain,
            varies: (whole.pulls(id))
                .and_then(|pulls| varies(&pulls, self.fitted, self.settings.seed)),
            raised,
            origin: self.effect(id).map(|effect| effect.info().origin),
            is_small: choice.is_small,
            square: without * without - after * after,
            gap_closed: Some((without - after) / (before - 1.0)),
        }
    }

    /// Takes out, the least first, what the held-out pushes do not miss.
    fn confirmed(
        &self,
        mut whole: Refit,
        mut fit: Fit,
        progress: &mut Progress,
        noise: (&NoiseModel, At),
    ) -> Result<Confirmed, DiagnosisError> {
        let [_, base] = whole.roughly_without(&ids(&progress.chosen))?.descriptions()?;
        let mut with_doubted = None;
        loop {
            let descriptions = whole.descriptions()?;
            let aside = Aside::new(self.aside, &descriptions[1], noise, self.settings)?;
            let (before, after) = (aside.outcome(&base)?, aside.outcome(&descriptions[1])?);
            let mut accepted = Vec::new();
            for (index, choice) in progress.chosen.iter().enumerate() {
                let (number, of) = (index + 1, progress.chosen.len());
                self.tell(DiagnosePhase::Confirming { effect: choice.id, number, of });
                let known = fit.effects.iter().find(|effect| effect.id == choice.id);
                let Some(effect) = known.cloned() else { continue };
                let other = whole.briefly_without(&[choice.id])?;
                let without = aside.outcome(&other.descriptions()?[1])?;
                let gains = aside.gains(&without, &after);
                let gain = self.gain((&other, &whole), gains)?;
                let models = (&whole, &progress.first_screen);
                let outcomes = [&before, &after, &without];
                accepted.push(self.accepted(choice, effect, models, (gain, outcomes)));
            }
            let doubted = accepted.iter().filter(|one| !one.gain.is_sure());
            let least = doubted.min_by(|a, b| a.gain.mean.total_cmp(&b.gain.mean));
            let Some(Accepted { id, gain, .. }) = least else {
                let models = [self.model, &descriptions[0]];
                let (error, raised) = aside.fall([&before, &after], models)?;
                if error.gap_closed.is_none() {
                    accepted.iter_mut().for_each(|one| one.gap_closed = None);
                }
                for one in &mut accepted {
                    one.is_small &= one.gap_closed.is_none_or(|closed| closed < SMALL_SHARE);
                }
                return Ok(Confirmed { accepted, error, raised, descriptions, with_doubted });
            };
            let (id, objection) = (*id, Objection::NotConfirmed { gain: *gain });
            // Beside what is no hint, nothing is known of what the hints explain.
            with_doubted = match (objection.is_hint(), with_doubted) {
                (true, None) => Some(descriptions[1].clone()),
                (true, earlier) => earlier,
                (false, _) => None,
            };
            progress.refused.push(Refused { id, objection });
            whole = match self.next_of_group(&whole, id, progress) {
                Some(other) => other,
                None => {
                    progress.chosen.retain(|one| one.id != id);
                    self.not_asking(whole, id)?
                }
            };
            fit = whole.fit(&self.fit_settings())?;
        }
    }
}

impl Search<'_> {
    /// The gain of each cluster fitted to by `with` over `without`, when the numbers of both are fitted
    /// without it.
    ///
    /// # Errors
    /// `OneCluster` where the others leave a number open.
    pub(super) fn left_out(
        &self,
        without: &Refit,
        with: &Refit,
    ) -> Result<Vec<f64>, DiagnosisError> {
        let parts = [without.left_out(with)?, with.left_out(with)?];
        Ok(Rules::gains(self.fitted, &parts))
    }

    /// A model that predicts the pushes that it was not fitted to as well.
    ///
    /// # Errors
    /// What a prediction refuses.
    pub(super) fn told_everywhere<'a>(
        &self,
        there: Refit<'a>,
    ) -> Result<Refit<'a>, DiagnosisError> {
        let [_, whole] = there.descriptions()?;
        for part in [self.all, self.aside] {
            Predictions::expected(&whole, &self.settings.own, part)?;
        }
        Ok(there)
    }

    /// The model with the next effect of a group in the place of one that is not confirmed; none
    /// where there is no other.
    fn next_of_group<'a>(
        &self,
        whole: &Refit<'a>,
        id: &'static str,
        progress: &mut Progress,
    ) -> Option<Refit<'a>> {
        let choice = progress.chosen.iter_mut().find(|one| one.id == id)?;
        while !choice.rivals.is_empty() {
            let rival = choice.rivals.remove(0);
            if let Some(other) = self.with_instead(whole, id, rival) {
                // One that does not settle is passed over.
                if let Ok(other) = other.asking(&[rival]).settled() {
                    choice.id = rival;
                    return Some(other);
                }
            }
        }
        None
    }

    /// A nominal number that may be off by chance.
    fn unsure_number(&self, fit: &Fit, progress: &Progress) -> Option<(&'static str, Objection)> {
        let is_chosen = |id: &str| progress.chosen.iter().any(|one| one.id == id);
        let is_number =
            |one: &&EffectFit| self.nominal_within(one.id).is_some() && is_chosen(one.id);
        let numbers = fit.effects.iter().filter(is_number);
        let with_p = numbers.map(|one| (one.id, p_of_number(one, &progress.first_screen)));
        let unsure = with_p.into_iter().find(|(_, p)| *p > NAME);
        unsure.map(|(id, p)| (id, Objection::NotSure { p }))
    }

    /// Whether a nominal number is off by more than twice its tolerance and twice its error.
    fn is_wrong(&self, nuisance: &NuisanceFit) -> bool {
        let Some(tolerance) = self.nominal_within(nuisance.id) else { return false };
        let miss = (nuisance.value - nuisance.nominal).abs();
        miss > TOLERANCES * (tolerance * nuisance.nominal.abs() + nuisance.se)
    }
}

/// What the held-out pushes confirm.
struct Confirmed {
    accepted: Vec<Accepted>,
    error: ErrorFall,
    raised: Option<Raised>,
    /// The model with it, and the same with the nuisances.
    descriptions: [Description; 2],
    /// The latter with what the held-out pushes only hint at.
    with_doubted: Option<Description>,
}

/// An effect of a fit that the data leave open.
fn open(fit: &Fit, chosen: &[Choice]) -> Option<(&'static str, Objection)> {
    let is_chosen = |id: &str| chosen.iter().any(|one| one.id == id);
    let chosen = fit.effects.iter().filter(|effect| is_chosen(effect.id));
    chosen.into_iter().find_map(|effect| match &effect.undetermined {
        None | Some(Undetermined::LooksLike { .. }) => None,
        Some(why) => Some((effect.id, Objection::Undetermined { why: why.to_string() })),
    })
}

/// Whether friction with the table is off by no more than friction along and across a direction: what
/// is nominal may be either of them, so this is no second finding.
fn is_mean_friction(here: &Refit, nuisance: &NuisanceFit) -> bool {
    let ratio = |id: &str| here.values_of(id).map_or(1.0, |values| values[0]);
    let spread = 0.5 * (ratio("table-anisotropy") * ratio("body-anisotropy")).ln();
    let miss = (nuisance.value / nuisance.nominal).ln().abs();
    let open = 2.0 * nuisance.se / nuisance.value;
    nuisance.id == "support-friction" && spread > 0.0 && miss <= spread + open
}

#[cfg(test)]
mod tests {
    use crate::synthetic::{in_more_noise, pushed_with};
    use crate::{DiagnoseSettings, Grade, diagnose};

    #[test]
    fn a_nominal_number_farther_off_than_a_screen_expects_is_named_in_noise_that_hides_what_it_does()
     {
        const RATIO: f64 = 0.5;
        let (observed, model, truth) = pushed_with(("pressure-radius", &[RATIO]), 1);
        let observed = in_more_noise(observed, &truth, 60.0);
        let found = diagnose(&observed, &model, &DiagnoseSettings::default()).unwrap().diagnosis;
        let told = found.effects.iter().find(|one| one.id == "pressure-radius").unwrap();
        assert_eq!(told.grade, Grade::Identified, "{}", told.why);
        let ends = told.parameters[0].low95.zip(told.parameters[0].high95);
        assert!(ends.is_some_and(|(low, high)| low < RATIO && RATIO < high), "{ends:?}");
    }
}
