//! The tables of `model.toml` as they stand in the text.

use std::collections::{BTreeMap, BTreeSet};

use effects::{Spread, by_id};
use nalgebra::Matrix3;
use serde::{Deserialize, Serialize};
use serde_spanned::Spanned;

use super::made_for::MadeFor;
use crate::{
    Analytical, Base, Calibration, CharacteristicLength, EffectiveSurface, Estimate, ModelEffect,
    Split, SurfaceKind, Unexplained,
};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Raw {
    pub schema: Spanned<String>,
    pub name: String,
    pub base: Spanned<RawBase>,
    #[serde(default)]
    pub effects: Vec<Spanned<RawEffect>>,
    pub learned: Option<Spanned<RawLearned>>,
    pub made_for: Option<Spanned<MadeFor>>,
    pub calibration: Option<Spanned<Calibration>>,
    pub split: Option<Spanned<Split>>,
}

#[derive(Serialize)]
pub(super) struct RawOut<'a> {
    pub schema: &'a str,
    pub name: &'a str,
    pub base: RawBase,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub effects: Vec<RawEffect>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub learned: Option<RawLearned>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub made_for: Option<&'a MadeFor>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub calibration: Option<&'a Calibration>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub split: Option<&'a Split>,
}

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields, expecting = "a table with the kind of the model, as `[base]`")]
pub(super) struct RawBase {
    pub kind: Spanned<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limit_surface: Option<Spanned<String>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub n_points: Option<Spanned<i64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pressure: Option<Spanned<String>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scatter_per_m: Option<Spanned<[[f64; 3]; 3]>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pusher_friction: Option<Spanned<Estimate>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub characteristic_length: Option<Spanned<Estimate>>,
    /// Of a measured surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub quartic: Option<Spanned<EffectiveSurface>>,
}

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields, expecting = "a table with the id of an effect, as `[[effects]]`")]
pub(super) struct RawEffect {
    pub id: Spanned<String>,
    #[serde(default)]
    pub parameters: BTreeMap<String, Spanned<RawParameter>>,
}

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields, expecting = "a table with a value, as `{ value = 0.3 }`")]
pub(super) struct RawParameter {
    pub value: f64,
    #[serde(default)]
    pub se: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// How it differs from push to push.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub per_push: Option<Spread>,
    /// How it differs from session to session.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub per_session: Option<Spread>,
    /// How it differs from place to place.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub per_place: Option<Spread>,
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub source: String,
}

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields, expecting = "a table with the file of the weights, as `[learned]`")]
pub(super) struct RawLearned {
    pub weights: String,
    pub sha256: String,
    /// What a hybrid learnt with; `gp` if it is not there.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub process: Option<Spanned<String>>,
    pub inputs: Vec<String>,
    /// For people; the weights have it too.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unexplained: Option<Unexplained>,
}

impl RawBase {
    pub(super) fn of(base: &Base) -> Self {
        match base {
            Base::Analytical(model) => Self::of_analytical("analytical", model),
            Base::Hybrid(model) => Self::of_analytical("hybrid", model),
            Base::Process(kind) => Self {
                kind: new(kind.id().to_owned()),
                limit_surface: None,
                n_points: None,
                pressure: None,
                scatter_per_m: None,
                pusher_friction: None,
                characteristic_length: None,
                quartic: None,
            },
        }
    }

    fn of_analytical(kind: &str, model: &Analytical) -> Self {
        let n_points = match model.surface() {
            SurfaceKind::Points { n_points } => i64::try_from(n_points).ok(),
            _ => None,
        };
        let quartic = match model.surface() {
            SurfaceKind::Effective(surface) => Some(new(surface)),
            _ => None,
        };
        let (pressure, length) = match model.length() {
            CharacteristicLength::UniformPressure if quartic.is_some() => (None, None),
            CharacteristicLength::UniformPressure => (Some(new("uniform".to_owned())), None),
            CharacteristicLength::Given(length) => (None, Some(new(length.clone()))),
        };
        let scatter = *model.scatter();
        Self {
            kind: new(kind.to_owned()),
            limit_surface: Some(new(model.surface().name().to_owned())),
            n_points: n_points.map(new),
            pressure,
            scatter_per_m: (scatter != Matrix3::zeros()).then(|| new(scatter.transpose().into())),
            pusher_friction: Some(new(model.pusher_friction().clone())),
            characteristic_length: length,
            quartic,
        }
    }
}

impl RawEffect {
    pub(super) fn of(effect: &ModelEffect) -> Self {
        let about = by_id(&effect.id).ok().map(|effect| effect.info());
        let unit = |name: &str| {
            let known = about?.parameters.iter().find(|parameter| parameter.name == name)?;
            Some(known.unit.to_owned())
        };
        let parameter = |(name, estimate): (&String, &Estimate)| {
            let Estimate { value, se, source } = estimate.clone();
            let [per_push, per_session, per_place] =
                [&effect.per_push, &effect.per_session, &effect.per_place]
                    .map(|spreads| spreads.get(name).copied());
            let unit = unit(name);
            let raw = RawParameter { value, se, unit, per_push, per_session, per_place, source };
            (name.clone(), new(raw))
        };
        let nothing =
            |(_, estimate): &(&String, &Estimate)| estimate.value == 0.0 && estimate.se == 0.0;
        let mut told: BTreeSet<&str> = match about {
            Some(_) => effect
                .parameters
                .iter()
                .filter(|one| !nothing(one))
                .map(|(name, _)| name.as_str())
                .collect(),
            None => effect.parameters.keys().map(String::as_str).collect(),
        };
        while let Some(more) = about.and_then(|about| about.missing(|name| told.contains(name))) {
            told.insert(more.name);
        }
        let told = effect.parameters.iter().filter(|(name, _)| told.contains(name.as_str()));
        Self { id: new(effect.id.clone()), parameters: told.map(parameter).collect() }
    }
}

/// A value that stands nowhere in a text yet.
pub(super) fn new<T>(value: T) -> Spanned<T> {
    Spanned::new(0..0, value)
}
