//! What was hidden, in the words of the catalogue; opened after the answer is given.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result};
use effects::by_id;
use plant::{Nominal, Variation, effect_kinds};
use serde::{Deserialize, Serialize};

/// An effect that is in a set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct TrueEffect {
    pub(super) id: String,
    /// As the simulator has them, in SI units.
    pub(super) values: BTreeMap<String, f64>,
}

/// What a sealed file tells.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Truth {
    /// What was hidden.
    pub(super) hidden: Vec<TrueEffect>,
    /// What the pushes of the set share beside it: the mean of what was drawn for each, and of what a rough table
    /// did to its friction, where that is more than pushes alone scatter to. The sessions of a set have draws of
    /// their own.
    pub(super) drawn: Vec<TrueEffect>,
}

/// The part of a sealed file that scores need.
#[derive(Deserialize)]
struct Sealed {
    hidden: Vec<TrueEffect>,
    pushes: Vec<SealedPush>,
}

#[derive(Deserialize)]
struct SealedPush {
    variation: Variation,
    table_friction: f64,
}

impl SealedPush {
    /// What differs from push to push, with the friction of the table where it took place.
    fn with_table(self) -> Variation {
        let support_friction = self.variation.support_friction * self.table_friction;
        Variation { support_friction, ..self.variation }
    }
}

/// Standard errors of the mean by which what a set shares stands out of its pushes' scatter.
const STANDS_OUT: f64 = 3.0;

/// Opens a sealed truth, beside what the manifest claims.
///
/// # Errors
/// A file that cannot be read or is no truth.
pub(super) fn open(path: &Path, nominal: &Nominal) -> Result<Truth> {
    let text =
        fs::read_to_string(path).with_context(|| format!("cannot open {}", path.display()))?;
    let Sealed { hidden, pushes } = toml::from_str(&text)?;
    let variations: Vec<Variation> = pushes.into_iter().map(SealedPush::with_table).collect();
    let is_hidden = |one: &TrueEffect| hidden.iter().any(|other| other.id == one.id);
    let mut drawn = drawn(&variations, nominal);
    drawn.retain(|one| !is_hidden(one));
    Ok(Truth { hidden, drawn })
}

/// A number of an effect: its name, its nominal value, and what it is of a push.
type Number<'a> = (&'a str, f64, &'a dyn Fn(&Variation) -> f64);

/// The effects whose numbers the pushes of a set share.
fn drawn(pushes: &[Variation], nominal: &Nominal) -> Vec<TrueEffect> {
    let effect = |id: &str, numbers: &[Number<'_>]| {
        let mut stands_out = false;
        let values = numbers.iter().map(|(name, usual, of)| {
            let (mean, se) = mean(&pushes.iter().map(of).collect::<Vec<_>>());
            stands_out |= (mean - usual).abs() > STANDS_OUT * se;
            ((*name).to_owned(), mean)
        });
        let values = values.collect();
        stands_out.then(|| TrueEffect { id: id.to_owned(), values })
    };
    let all = [
        effect(
            "support-friction",
            &[("coefficient", nominal.support_friction, &|push| {
                nominal.support_friction * push.support_friction
            })],
        ),
        effect(
            "pusher-friction",
            &[("coefficient", nominal.pusher_friction, &|push| {
                nominal.pusher_friction * push.tip_friction
            })],
        ),
        effect("pressure-radius", &[("ratio", 1.0, &|push| push.pressure_radius)]),
        effect(
            "friction-center-offset",
            &[
                ("x", 0.0, &|push| push.pressure_shift[0]),
                ("y", 0.0, &|push| push.pressure_shift[1]),
            ],
        ),
        effect("contact-bias", &[("offset", 0.0, &|push| push.contact_shift)]),
        effect(
            "force-bias",
            &[("x", 0.0, &|push| push.force_bias[0]), ("y", 0.0, &|push| push.force_bias[1])],
        ),
    ];
    all.into_iter().flatten().collect()
}

/// The mean with its standard error.
fn mean(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    (mean, (squares / (n * (n - 1.0).max(1.0))).sqrt())
}

impl TrueEffect {
    /// Whether the catalogue's law is the simulator's, so that its parameters can be compared: a
    /// pusher of the simulator has no state but its slip, where the catalogue's sticks or slides; its feet,
    /// rims and waves over the table follow from a few numbers, and its friction rises towards vertices.
    pub(super) fn is_same_law(&self) -> bool {
        let own = [
            "pusher-stiction",
            "support-points",
            "pressure-map",
            "vertex-contact",
            "friction-field",
        ];
        !own.contains(&self.id.as_str())
    }

    /// The values as parameters of the catalogue's effect; those that it shares alone. Most are the same
    /// numbers in the same order.
    ///
    /// The simulator tells where the tracked frame is in the outline, what is added to the reading
    /// of the force on the tip, and a shift to the left of the inward normal; the catalogue tells
    /// where the outline is in the tracked frame, what is added to the force on the object, and a
    /// shift towards larger p.
    pub(super) fn parameters(&self) -> Vec<(&'static str, f64)> {
        let value = |name: &str| self.values.get(name).copied().unwrap_or_default();
        let nominal = Nominal::default();
        match self.id.as_str() {
            "pusher-friction-asymmetry" => vec![("asymmetry", 0.5 * value("difference"))],
            "pusher-radius" => vec![("excess", value("radius") - nominal.pusher_radius)],
            "contact-bias" => vec![("shift", -value("offset"))],
            "inertia" => vec![("kappa", 1.0)],
            "pose-offset" => vec![("mx", -value("x")), ("my", -value("y"))],
            "yaw-offset" => vec![("yaw", -value("angle"))],
            "force-bias" => {
                vec![("fx", -value("x")), ("fy", -value("y")), ("turn", value("rotation"))]
            }
            id => {
                let kind = effect_kinds().into_iter().find(|kind| kind.id == id);
                let names = kind.map_or(&[][..], |kind| kind.parameters).iter().map(|p| p.name);
                let own = by_id(id).map_or(&[][..], |effect| effect.info().parameters);
                own.iter().zip(names).map(|(own, name)| (own.name, value(name))).collect()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use effects::{all, tested};
    use plant::{HiddenEffect, Nominal, Variation, effect_kinds};

    use super::{SealedPush, TrueEffect, drawn};

    #[test]
    fn what_all_pushes_share_stands_out_of_their_scatter() {
        let push = |k: usize, shared: f64| Variation {
            force_bias: [shared + 0.01 * (k % 5) as f64 - 0.02, 0.0],
            support_friction: 1.0 + 0.01 * (k % 3) as f64 - 0.01,
            ..Variation::default()
        };
        let ids = |shared: f64| -> Vec<String> {
            let pushes: Vec<_> = (0..60).map(|k| push(k, shared)).collect();
            drawn(&pushes, &Nominal::default()).into_iter().map(|effect| effect.id).collect()
        };
        assert_eq!(ids(0.0), Vec::<String>::new());
        assert_eq!(ids(0.01), ["force-bias"]);
    }

    #[test]
    fn a_table_that_rubs_more_where_it_is_pushed_on_is_a_larger_friction() {
        let push = |k: usize| SealedPush {
            variation: Variation { support_friction: 0.9, ..Variation::default() },
            table_friction: 1.4 + 0.01 * (k % 3) as f64 - 0.01,
        };
        let pushes: Vec<_> = (0..60).map(|k| push(k).with_table()).collect();
        let nominal = Nominal::default();
        let [friction] = drawn(&pushes, &nominal).try_into().unwrap();
        assert_eq!(friction.id, "support-friction");
        let expected = 0.9 * 1.4 * nominal.support_friction;
        assert!((friction.values["coefficient"] - expected).abs() < 1e-12);
    }

    #[test]
    fn every_effect_of_the_catalogue_has_its_parameters_and_no_other_has() {
        for kind in effect_kinds() {
            let known = all().iter().map(|effect| effect.info()).find(|about| about.id == kind.id);
            assert_eq!(known.is_some(), kind.in_catalogue);
            let values = HiddenEffect::typical(kind.id).unwrap().values;
            let values = values.into_iter().map(|(name, value)| (name.to_owned(), value));
            let told = TrueEffect { id: kind.id.into(), values: values.collect() };
            if !told.is_same_law() && kind.id != "pusher-stiction" {
                continue;
            }
            let names: Vec<_> = told.parameters().iter().map(|(name, _)| *name).collect();
            let own = known.map_or(Vec::new(), |about| {
                about.parameters.iter().map(|parameter| parameter.name).collect()
            });
            assert_eq!(names, own, "{}", kind.id);
        }
        for effect in tested() {
            let id = effect.info().id;
            assert!(effect_kinds().iter().any(|kind| kind.id == id), "{id} cannot be hidden");
        }
    }
}
