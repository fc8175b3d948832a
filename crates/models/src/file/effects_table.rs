//! The effects of a model file, checked against the catalogue.

use std::collections::BTreeMap;
use std::sync::Arc;

use effects::{Effect, EffectInfo, Parameter, all};
use serde_spanned::Spanned;

use super::raw::{Raw, RawEffect, RawParameter};
use super::source::Source;
use crate::{Estimate, ModelEffect, ModelError};

/// Of a parameter that the data do not determine, in its unit.
const LARGEST_SE: f64 = 1e9;

impl Source<'_> {
    /// The effects in the order of the file; `own` are those besides the catalogue.
    pub(super) fn effects(
        &self,
        raw: &Raw,
        own: &[Arc<dyn Effect>],
    ) -> Result<Vec<ModelEffect>, ModelError> {
        let base = raw.base.get_ref();
        let mut effects: Vec<ModelEffect> = Vec::new();
        for effect in &raw.effects {
            let start = effect.span().start;
            if !["analytical", "hybrid"].contains(&base.kind.get_ref().as_str()) {
                let problem =
                    "effects act in mechanics, of which this kind has none; remove the block";
                return Err(self.invalid(start, "effects", problem));
            }
            let effect = self.effect(effect, own)?;
            if effects.iter().any(|known| known.id == effect.id) {
                let problem = format!("{} stands here for the second time; remove one", effect.id);
                return Err(self.invalid(start, "effects", problem));
            }
            if effect.id == "pressure-radius" && base.characteristic_length.is_some() {
                let problem = "pressure-radius and base.characteristic_length say the same; \
                    give pressure = \"uniform\" instead of the length, or remove the block";
                return Err(self.invalid(start, "effects", problem));
            }
            effects.push(effect);
        }
        Ok(effects)
    }

    fn effect(
        &self,
        raw: &Spanned<RawEffect>,
        own: &[Arc<dyn Effect>],
    ) -> Result<ModelEffect, ModelError> {
        let RawEffect { id, parameters: raw_parameters } = raw.get_ref();
        let known = || own.iter().chain(all()).map(|effect| effect.info());
        let Some(about) = known().find(|about| about.id == id.get_ref()) else {
            let ids: Vec<_> = known().map(|about| about.id).collect();
            return Err(self.unknown(id, "effects.id", &ids));
        };
        if let Some(parameter) = about.missing(|name| raw_parameters.contains_key(name)) {
            let problem = format!("is missing; {} needs {}", about.id, described(about));
            let key = format!("effects.parameters.{}", parameter.name);
            return Err(self.invalid(raw.span().start, &key, problem));
        }
        let estimates = raw_parameters.iter().map(|(name, value)| {
            let key = format!("effects.parameters.{name}");
            match about.parameters.iter().find(|parameter| parameter.name == name) {
                Some(parameter) => Ok((name.clone(), self.parameter(value, parameter, &key)?)),
                None => {
                    let problem = format!("is not known; {} has {}", about.id, described(about));
                    Err(self.invalid(value.span().start, &key, problem))
                }
            }
        });
        let mut parameters = estimates.collect::<Result<BTreeMap<_, _>, ModelError>>()?;
        for parameter in about.parameters {
            // What bears nothing is left out.
            let nothing = || Estimate::exact(0.0, "");
            parameters.entry(parameter.name.to_owned()).or_insert_with(nothing);
        }
        let mut effect = ModelEffect::new(id.get_ref(), parameters);
        for (name, raw) in raw_parameters {
            let RawParameter { per_push, per_session, per_place, .. } = raw.get_ref();
            effect.per_session.extend(per_session.map(|spread| (name.clone(), spread)));
            effect.per_push.extend(per_push.map(|spread| (name.clone(), spread)));
            effect.per_place.extend(per_place.map(|spread| (name.clone(), spread)));
        }
        let setting = effect.setting();
        let checked = setting.values(about).and_then(|values| about.check(&values));
        let checked = checked.and_then(|()| setting.check_spreads());
        checked.map_err(|error| self.invalid(raw.span().start, "effects", error.to_string()))?;
        Ok(effect)
    }

    fn parameter(
        &self,
        raw: &Spanned<RawParameter>,
        parameter: &Parameter,
        key: &str,
    ) -> Result<Estimate, ModelError> {
        let RawParameter { value, se, unit, source, per_push, per_session, per_place } =
            raw.get_ref();
        let refuse = |name: &str, problem: String| {
            Err(self.invalid(raw.span().start, &format!("{key}.{name}"), problem))
        };
        let (low, high) = parameter.range;
        if !(low..=high).contains(value) {
            let unit = parameter.unit;
            return refuse(
                "value",
                format!("must be from {low} to {high} (unit {unit}), got {value}"),
            );
        }
        if !(0.0..=LARGEST_SE).contains(se) {
            return refuse("se", format!("must be from 0 to {LARGEST_SE:e}, got {se:?}"));
        }
        let spreads =
            [("per_push", per_push), ("per_session", per_session), ("per_place", per_place)];
        for (key, spread) in spreads {
            if let Some(Err(error)) = spread.map(|spread| spread.check(parameter)) {
                return refuse(key, error.to_string());
            }
        }
        if per_push.zip(*per_session).is_some_and(|(push, session)| !push.is_like(session)) {
            return refuse(
                "per_session",
                "must be in the unit of per_push, `sd` or `relative_sd`".into(),
            );
        }
        match unit {
            Some(unit) if unit != parameter.unit => {
                refuse("unit", format!("must be \"{}\", got \"{unit}\"", parameter.unit))
            }
            _ => Ok(Estimate { value: *value, se: *se, source: source.clone() }),
        }
    }
}

/// The parameters with their units and ranges, for messages.
fn described(about: &EffectInfo) -> String {
    let one = |parameter: &Parameter| {
        let Parameter { name, unit, range: (low, high), .. } = parameter;
        format!("{name} (from {low} to {high}, unit {unit})")
    };
    about.parameters.iter().map(one).collect::<Vec<_>>().join(", ")
}
