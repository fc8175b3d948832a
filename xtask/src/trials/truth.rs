//! What was hidden, in the words of the catalogue; opened after the answer is given.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result};
use plant::Nominal;
use serde::{Deserialize, Serialize};

/// An effect that is in a set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct TrueEffect {
    pub(super) id: String,
    /// As the simulator has them, in SI units.
    pub(super) values: BTreeMap<String, f64>,
}

/// The part of a sealed file that scores need.
#[derive(Deserialize)]
struct Sealed {
    hidden: Vec<TrueEffect>,
}

/// Opens a sealed truth.
///
/// # Errors
/// A file that cannot be read or is no truth.
pub(super) fn open(path: &Path) -> Result<Vec<TrueEffect>> {
    let text =
        fs::read_to_string(path).with_context(|| format!("cannot open {}", path.display()))?;
    let sealed: Sealed = toml::from_str(&text)?;
    Ok(sealed.hidden)
}

impl TrueEffect {
    /// Whether the catalogue's law is the simulator's, so that its parameters can be compared: a
    /// pusher of the simulator has no state but its slip, where the catalogue's sticks or slides.
    pub(super) fn is_same_law(&self) -> bool {
        self.id != "pusher-stiction"
    }

    /// The values as parameters of the catalogue's effect; those that it shares alone.
    ///
    /// The simulator tells where the tracked frame is in the outline, what is added to the reading
    /// of the force on the tip, and a shift to the left of the inward normal; the catalogue tells
    /// where the outline is in the tracked frame, what is added to the force on the object, and a
    /// shift towards larger p.
    pub(super) fn parameters(&self) -> Vec<(&'static str, f64)> {
        let value = |name: &str| self.values.get(name).copied().unwrap_or_default();
        let nominal = Nominal::default();
        match self.id.as_str() {
            "support-friction" | "pusher-friction" => vec![("friction", value("coefficient"))],
            "pressure-radius" => vec![("ratio", value("ratio"))],
            "limit-surface-shape" => vec![("lambda", value("patch_share"))],
            "friction-center-offset" => vec![("dx", value("x")), ("dy", value("y"))],
            "table-anisotropy" | "body-anisotropy" => {
                vec![("ratio", value("ratio")), ("direction", value("direction"))]
            }
            "friction-gradient" => vec![("gx", value("x")), ("gy", value("y"))],
            "table-tilt" => vec![("ax", value("x")), ("ay", value("y"))],
            "rate-dependent-friction" => vec![("k", value("slope")), ("v0", value("speed"))],
            "pusher-stiction" => {
                vec![("ratio", value("ratio")), ("stribeck_velocity", value("speed"))]
            }
            "support-stiction" => {
                vec![("breakaway", value("ratio")), ("stribeck_velocity", value("speed"))]
            }
            "friction-drift" => vec![("change", value("change"))],
            "pusher-friction-asymmetry" => vec![("asymmetry", 0.5 * value("difference"))],
            "pusher-radius" => vec![("excess", value("radius") - nominal.pusher_radius)],
            "contact-bias" => vec![("shift", -value("offset"))],
            "edge-rounding" => vec![("radius", value("radius"))],
            "pusher-compliance" => vec![("compliance", value("compliance"))],
            "inertia" => vec![("kappa", 1.0)],
            "pose-offset" => vec![("mx", -value("x")), ("my", -value("y"))],
            "yaw-offset" => vec![("yaw", -value("angle"))],
            "stream-latency" => vec![("latency", value("delay"))],
            "force-bias" => {
                vec![("fx", -value("x")), ("fy", -value("y")), ("turn", value("rotation"))]
            }
            _ => Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use effects::all;
    use plant::{HiddenEffect, effect_kinds};

    use super::TrueEffect;

    #[test]
    fn every_effect_of_the_catalogue_has_its_parameters_and_no_other_has() {
        for kind in effect_kinds() {
            let values = HiddenEffect::typical(kind.id).unwrap().values;
            let values = values.into_iter().map(|(name, value)| (name.to_owned(), value));
            let told = TrueEffect { id: kind.id.into(), values: values.collect() }.parameters();
            let known = all().iter().map(|effect| effect.about()).find(|about| about.id == kind.id);
            assert_eq!(known.is_some(), kind.in_catalogue);
            let names: Vec<_> = told.iter().map(|(name, _)| *name).collect();
            let own = known.map_or(Vec::new(), |about| {
                about.parameters.iter().map(|parameter| parameter.name).collect()
            });
            assert_eq!(names, own, "{}", kind.id);
        }
    }
}
