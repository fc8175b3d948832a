//! Fits as `pushlab fit` and `pushlab add --fit` make them, without intervals.

use anyhow::Result;
use diagnosis::{Fit, FitSettings, NoiseModel, Observations, SupportPointsFit, fit_with_noise};
use effects::{Effect, Setting, SupportPoints, by_id};
use models::{Description, ModelEffect};

/// The model with some effects fitted, which are added at "off" where it lacks them.
///
/// # Errors
/// What the fit says.
pub(super) fn fitted(
    observations: &Observations,
    model: Description,
    free: &[&str],
) -> Result<Description> {
    Ok(fit(observations, model, free, SupportPointsFit::default())?.description)
}

/// The same with what the fit leaves open, and what is known of support points.
///
/// # Errors
/// What the fit says.
pub(super) fn fit(
    observations: &Observations,
    mut model: Description,
    free: &[&str],
    points: SupportPointsFit,
) -> Result<Fit> {
    // The points stand for the length.
    if free.contains(&SupportPoints.info().id) {
        model.effects.retain(|effect| effect.id != "pressure-radius");
    }
    for id in free.iter().filter(|id| **id != "pusher-friction") {
        if !model.effects.iter().any(|effect| effect.id == **id) {
            let about = by_id(id)?.info();
            let off = observations.off(&model, about)?;
            model.effects.push(ModelEffect::from(Setting::new(about, &off)));
        }
    }
    let settings =
        FitSettings { priors: false, resemblances: false, points, ..FitSettings::default() };
    let noise = NoiseModel::learn(&model, &[], observations)?;
    Ok(fit_with_noise(observations, &model, free, &noise, &settings)?)
}

/// The points of a model that has them: x and y in m, and the share.
pub(super) fn feet(model: &Description) -> Option<Vec<[f64; 3]>> {
    let about = SupportPoints.info();
    let effect = model.effects.iter().find(|effect| effect.id == about.id)?;
    let values = effect.setting().values(about).ok()?;
    let points = values.chunks_exact(3).map(|point| [point[0], point[1], point[2]]);
    Some(points.filter(|point| point[2] > 0.0).collect())
}
