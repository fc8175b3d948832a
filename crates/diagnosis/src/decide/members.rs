//! What each member of a group would be, in the place of the one that was added.

use models::Description;

use super::DiagnoseSettings;
use super::claims::Claims;
use super::found::Found;
use crate::{EffectFit, FitSettings, Observations, fit_with_noise};

/// The members of groups that were not added, each fitted beside the other claims, with intervals
/// by standard errors.
///
/// A member whose fit does not settle is left out: its one-step estimate is all that is told.
pub(super) fn members(
    found: &Found,
    claims: &Claims,
    fitted: &Observations,
    model: &Description,
    settings: &DiagnoseSettings,
) -> Vec<EffectFit> {
    let claimed: Vec<&str> = found.accepted.iter().map(|accepted| accepted.id).collect();
    let settings = FitSettings {
        own: settings.own.clone(),
        tolerances: settings.screen.tolerances,
        resemblances: false,
        ..FitSettings::default()
    };
    let member = |(added, other): (&'static str, &'static str)| {
        let ids: Vec<&str> =
            claimed.iter().map(|id| if *id == added { other } else { id }).collect();
        let fit = fit_with_noise(fitted, model, &ids, &found.noise, &settings).ok()?;
        fit.effects.into_iter().find(|effect| effect.id == other)
    };
    let pairs = claims.groups.iter().filter_map(|group| group.split_first());
    pairs
        .flat_map(|(added, others)| others.iter().map(|other| (*added, *other)))
        .filter_map(member)
        .collect()
}
