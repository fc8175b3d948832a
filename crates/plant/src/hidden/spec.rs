//! A hidden effect as it is written: `table-anisotropy: ratio=1.3, direction_deg=34`.

use std::collections::BTreeMap;
use std::str::FromStr;

use serde::Serialize;

use super::{EffectKind, Parameter, effect_kind, effect_kinds};
use crate::{Design, PlantError, Truth};

pub(super) const SURPRISE: &str = "surprise";

/// What is to be hidden.
#[derive(Clone, Debug, PartialEq)]
pub enum Hidden {
    /// An effect of a given size.
    Effect(HiddenEffect),
    /// Any effect of any noticeable size, drawn by the seed of the set.
    Surprise,
}

/// An effect with its values, in SI units.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HiddenEffect {
    /// Its name.
    pub id: &'static str,
    /// Value of every parameter, in SI units.
    pub values: BTreeMap<&'static str, f64>,
}

impl HiddenEffect {
    /// An effect with its typical values.
    ///
    /// # Errors
    /// `Hidden` for a name that is not known.
    pub fn typical(id: &str) -> Result<Self, PlantError> {
        let kind = effect_kind(id).ok_or_else(|| unknown_id(id, id))?;
        Ok(Self::of(kind, |parameter| parameter.typical))
    }

    pub(crate) fn of(kind: &'static EffectKind, value: impl FnMut(&Parameter) -> f64) -> Self {
        let names = kind.parameters.iter().map(|parameter| parameter.name);
        Self { id: kind.id, values: names.zip(kind.parameters.iter().map(value)).collect() }
    }

    /// The same effect with one value changed, in SI units.
    ///
    /// # Errors
    /// `Hidden` for a parameter that the effect does not have, or a value out of its range.
    pub fn with(mut self, name: &str, value: f64) -> Result<Self, PlantError> {
        let parameters = effect_kind(self.id).map_or(&[][..], |kind| kind.parameters);
        let Some(parameter) = parameters.iter().find(|parameter| parameter.name == name) else {
            return Err(unknown_parameter(self.id, name, parameters));
        };
        let (low, high) = parameter.range;
        let whole = parameter.quantity != super::Quantity::Index || value.fract() == 0.0;
        if !((low..=high).contains(&value) && whole) {
            let unit = match parameter.quantity.unit() {
                "1" => String::new(),
                unit => format!(" {unit}"),
            };
            let what = format!("{name} = {value}{unit} is not between {low} and {high}{unit}");
            return Err(PlantError::Hidden { text: self.id.into(), what });
        }
        self.values.insert(parameter.name, value);
        Ok(self)
    }

    /// Puts the effect into a truth, or into a design where it is a matter of the pushes.
    ///
    /// # Errors
    /// `Design` for an effect of the pushes where the design leaves no choice.
    pub fn apply(&self, truth: &mut Truth, design: &mut Design) -> Result<(), PlantError> {
        let kind = effect_kind(self.id).ok_or_else(|| unknown_id(self.id, self.id))?;
        let value = |parameter: &Parameter| {
            self.values.get(parameter.name).copied().unwrap_or(parameter.typical)
        };
        let values: Vec<_> = kind.parameters.iter().map(value).collect();
        (kind.apply)(truth, design, &values)
    }
}

impl FromStr for Hidden {
    type Err = PlantError;

    /// Reads `id`, `id: name_unit=value, …` or `surprise`.
    fn from_str(text: &str) -> Result<Self, PlantError> {
        let (id, rest) = text.split_once(':').unwrap_or((text, ""));
        let id = id.trim();
        if id == SURPRISE && rest.trim().is_empty() {
            return Ok(Self::Surprise);
        }
        let kind = effect_kind(id).ok_or_else(|| unknown_id(text, id))?;
        let mut effect = HiddenEffect::typical(id)?;
        let mut given: Vec<&str> = Vec::new();
        for item in rest.split(',').map(str::trim).filter(|item| !item.is_empty()) {
            let fail = |what| PlantError::Hidden { text: text.into(), what };
            let Some((key, value)) = item.split_once('=') else {
                return Err(fail(format!("`{item}` is not written as name=value")));
            };
            let (key, value) = (key.trim(), value.trim());
            let Some((parameter, scale)) = find(kind.parameters, key) else {
                return Err(unknown_parameter(text, key, kind.parameters));
            };
            let value: f64 =
                value.parse().map_err(|_| fail(format!("`{value}` is not a number")))?;
            if given.contains(&parameter.name) {
                return Err(fail(format!("`{}` is given twice", parameter.name)));
            }
            given.push(parameter.name);
            effect = effect.with(parameter.name, scale * value)?;
        }
        Ok(Self::Effect(effect))
    }
}

/// The parameter that a key with a unit's ending names, and the unit's size.
fn find(parameters: &'static [Parameter], key: &str) -> Option<(&'static Parameter, f64)> {
    parameters.iter().find_map(|parameter| {
        let suffix = key.strip_prefix(parameter.name)?;
        let mut suffixes = parameter.quantity.suffixes().iter();
        suffixes.find(|(known, _)| *known == suffix).map(|(_, scale)| (parameter, *scale))
    })
}

fn unknown_id(text: &str, id: &str) -> PlantError {
    let known: Vec<_> = effect_kinds().iter().map(|kind| kind.id).collect();
    let what = format!("`{id}` is not known, expected {SURPRISE} or one of {}", known.join(", "));
    PlantError::Hidden { text: text.into(), what }
}

fn unknown_parameter(text: &str, key: &str, parameters: &[Parameter]) -> PlantError {
    let known: Vec<_> = parameters.iter().map(|parameter| parameter.keys().join(" or ")).collect();
    let what = format!("`{key}` is not known, expected {}", known.join(", "));
    PlantError::Hidden { text: text.into(), what }
}

#[cfg(test)]
mod tests {
    use super::{Hidden, HiddenEffect};
    use crate::{Design, PlantError, Truth, effect_kinds};

    fn parsed(text: &str) -> HiddenEffect {
        match text.parse().unwrap() {
            Hidden::Effect(effect) => effect,
            Hidden::Surprise => panic!("an effect"),
        }
    }

    fn refused(text: &str) -> String {
        text.parse::<Hidden>().unwrap_err().to_string()
    }

    #[test]
    fn names_values_and_units_are_read() {
        let effect = parsed("table-anisotropy: ratio=1.4, direction_deg = 90");
        assert_eq!(effect.values["ratio"], 1.4);
        assert_eq!(effect.values["direction"], std::f64::consts::FRAC_PI_2);
        assert_eq!(parsed("pose-offset: x_mm=-3").values["x"], -0.003);
        assert_eq!(parsed("pose-offset"), HiddenEffect::typical("pose-offset").unwrap());
        assert_eq!("surprise".parse::<Hidden>().unwrap(), Hidden::Surprise);
    }

    #[test]
    fn what_is_wrong_is_answered_with_what_is_allowed() {
        let message = refused("table-anistropy: ratio=1.3");
        assert!(message.contains("`table-anistropy` is not known"), "{message}");
        assert!(message.contains("surprise") && message.contains("worn-groove"), "{message}");
        assert_eq!(
            refused("table-anisotropy: direction=34"),
            "hidden effect `table-anisotropy: direction=34`: `direction` is not known, expected \
             ratio, direction_rad or direction_deg"
        );
        assert!(refused("yaw-offset: angle_deg").contains("not written as name=value"));
        assert!(refused("yaw-offset: angle_deg=x").contains("`x` is not a number"));
        assert!(refused("yaw-offset: angle_deg=1, angle_rad=0.1").contains("given twice"));
        assert!(refused("pusher-radius: radius_m=4.75").contains("radius = 4.75 m is not between"));
        assert!(refused("table-anisotropy: ratio=9").ends_with("9 is not between 0.3 and 3"));
        assert!(refused("chipped-corner: vertex=0.5").contains("is not between"));
    }

    #[test]
    fn ids_are_unique_and_typical_values_change_a_possible_truth() {
        let mut ids = std::collections::BTreeSet::new();
        for kind in effect_kinds() {
            assert!(ids.insert(kind.id), "{}", kind.id);
            let (mut truth, mut design) = (Truth::default(), Design::default());
            HiddenEffect::typical(kind.id).unwrap().apply(&mut truth, &mut design).unwrap();
            truth.check().unwrap();
            assert_ne!((truth, design), (Truth::default(), Design::default()), "{}", kind.id);
            for parameter in kind.parameters {
                let (low, high) = parameter.range;
                assert!(
                    (low..=high).contains(&parameter.typical),
                    "{} {}",
                    kind.id,
                    parameter.name
                );
            }
        }
        assert!(effect_kinds().iter().filter(|kind| !kind.in_catalogue).count() >= 8);
    }

    #[test]
    fn an_effect_with_its_off_values_is_the_plain_rig() {
        for kind in effect_kinds() {
            let off =
                HiddenEffect::of(kind, |parameter| parameter.off.unwrap_or(parameter.typical));
            let (mut truth, mut design) = (Truth::default(), Design::default());
            off.apply(&mut truth, &mut design).unwrap();
            // Where and how no longer matter, so they are taken back before comparing.
            truth.table_grain.direction = 0.0;
            truth.body_grain.direction = 0.0;
            assert!(design.speeds.is_empty() || design.speeds == [0.02], "{}", kind.id);
            assert_eq!(truth.tip.compliance, Truth::default().tip.compliance, "{}", kind.id);
        }
    }

    #[test]
    fn a_speed_of_the_pushes_cannot_be_hidden_in_a_grid() {
        let mut design = Design { layout: crate::Layout::Thesis, ..Design::default() };
        let effect = HiddenEffect::typical("inertia").unwrap();
        let error = effect.apply(&mut Truth::default(), &mut design).unwrap_err();
        assert!(matches!(error, PlantError::Design { .. }));
    }
}
