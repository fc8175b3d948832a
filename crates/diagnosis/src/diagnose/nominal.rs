//! The last of a search: nominal numbers that are wrong, and the models one after the other.

use models::{Analytical, Base, Description, Estimate};

use super::rules::{Objection, Rules};
use super::search::{Accepted, Choice, Found, Progress, Refused, Search, ids};
use crate::fit::Refit;
use crate::{DiagnosisError, Fit, NuisanceFit, Screen, Undetermined};

/// The numbers that every fit leaves open, and how exactly a manifest is taken to know them.
const NOMINAL: [(&str, f64); 3] =
    [("support-friction", 0.03), ("pusher-friction", 0.03), ("pressure-radius", 0.01)];

impl Search<'_> {
    /// Adds the nominal numbers that the best model does not leave at their values, takes out what
    /// has no interval, and fits the effects in their order of adding.
    ///
    /// Nominal numbers are left open in every fit, so no effect is blamed for them; here they are
    /// asked for.
    pub(super) fn concluded(
        &self,
        here: &Refit,
        mut progress: Progress,
        last_screen: Screen,
    ) -> Result<Found, DiagnosisError> {
        let claimed = self.wrong_numbers(here, &mut progress.refused)?;
        let as_choice =
            |one: &NuisanceFit| Choice { id: one.id, p_adjusted: 1.0, rivals: Vec::new() };
        progress.chosen.extend(claimed.iter().map(as_choice));
        let mut whole = here.asking(&ids(&progress.chosen));
        let fit = loop {
            let fit = whole.fit(&self.fit_settings(true))?;
            let Some((id, objection)) = open(&fit) else { break fit };
            progress.chosen.retain(|one| one.id != id);
            progress.refused.push(Refused { id, objection });
            whole = match claimed.iter().any(|one| one.id == id) {
                true => here.asking(&ids(&progress.chosen)),
                false => whole.without(&[id])?,
            };
        };
        let is_claimed =
            |one: &&NuisanceFit| progress.chosen.iter().any(|other| other.id == one.id);
        let claimed: Vec<&NuisanceFit> = claimed.iter().filter(is_claimed).collect();
        let (base, accepted) = chain(&whole, &progress.chosen, &claimed, &fit)?;
        let first_screen = progress.first_screen.unwrap_or_else(|| last_screen.clone());
        Ok(Found { base, first_screen, last_screen, accepted, refused: progress.refused })
    }

    /// Nominal numbers that are off by more than their tolerance and matter.
    fn wrong_numbers(
        &self,
        here: &Refit,
        refused: &mut Vec<Refused>,
    ) -> Result<Vec<NuisanceFit>, DiagnosisError> {
        let mut claimed = Vec::new();
        for nuisance in here.fit(&self.fit_settings(false))?.nuisances {
            if !is_wrong(&nuisance) {
                continue;
            }
            let size = here.size_against(nuisance.id, &[nuisance.nominal])?;
            match size < Rules::SIZE {
                true => {
                    let objection = Objection::Small { size };
                    refused.push(Refused { id: nuisance.id, objection });
                }
                false => claimed.push(nuisance),
            }
        }
        Ok(claimed)
    }
}

/// The model without effects, and with the first, the first two … of them, each fitted anew; a
/// nominal number that is claimed stays nominal before it is added.
fn chain(
    whole: &Refit,
    chosen: &[Choice],
    claimed: &[&NuisanceFit],
    fit: &Fit,
) -> Result<(Description, Vec<Accepted>), DiagnosisError> {
    let all = ids(chosen);
    let is_number = |id: &str| claimed.iter().any(|one| one.id == id);
    let model = |n: usize| -> Result<[Description; 2], DiagnosisError> {
        let later: Vec<&'static str> =
            all[n..].iter().copied().filter(|id| !is_number(id)).collect();
        let reduced = if later.is_empty() { None } else { Some(whole.without(&later)?) };
        let mut found = reduced.as_ref().unwrap_or(whole).descriptions()?;
        for nuisance in claimed.iter().filter(|one| !all[..n].contains(&one.id)) {
            for description in &mut found {
                *description = reset(description, nuisance)?;
            }
        }
        Ok(found)
    };
    let [_, base] = model(0)?;
    let mut accepted = Vec::new();
    for (index, choice) in chosen.iter().enumerate() {
        let [description, with_nuisances] = model(index + 1)?;
        let Some(effect) = fit.effects.iter().find(|effect| effect.id == choice.id) else {
            continue;
        };
        let p_adjusted = if is_number(choice.id) { effect.p } else { choice.p_adjusted };
        let (id, rivals, effect) = (choice.id, choice.rivals.clone(), effect.clone());
        accepted.push(Accepted { id, p_adjusted, rivals, effect, description, with_nuisances });
    }
    Ok((base, accepted))
}

/// An effect of a fit that the data leave open.
fn open(fit: &Fit) -> Option<(&'static str, Objection)> {
    fit.effects.iter().find_map(|effect| match &effect.undetermined {
        None | Some(Undetermined::LooksLike { .. }) => None,
        Some(why) => Some((effect.id, Objection::Undetermined { why: why.to_string() })),
    })
}

/// Whether a nominal number is off by more than twice its tolerance and twice its error.
fn is_wrong(nuisance: &NuisanceFit) -> bool {
    let known = NOMINAL.iter().find(|(id, _)| *id == nuisance.id);
    let Some((_, tolerance)) = known else { return false };
    let miss = (nuisance.value - nuisance.nominal).abs();
    miss > 2.0 * tolerance * nuisance.nominal.abs() + 2.0 * nuisance.se
}

/// The model with a nuisance at its nominal value.
fn reset(model: &Description, nuisance: &NuisanceFit) -> Result<Description, DiagnosisError> {
    let mut model = model.clone();
    let nominal = Estimate::exact(nuisance.nominal, "nominal");
    let carried = model.effects.iter_mut().find(|effect| effect.id == nuisance.id);
    if let Some(carried) = carried {
        carried.parameters.insert(nuisance.name.to_owned(), nominal);
    } else if let Base::Analytical(base) = &model.base
        && nuisance.id == "pusher-friction"
    {
        let other = Analytical::new(nominal, base.length().clone(), *base.scatter())?;
        model.base = Base::Analytical(other.with_surface(base.surface())?);
    }
    Ok(model)
}
