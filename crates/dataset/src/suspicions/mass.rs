//! Whether the mass is one that the outline can have.

use super::mistake::View;
use super::numbers::length;
use super::scene::Scene;
use super::{Check, Find, Suspicion};
use crate::curves::sample::quantile;

pub(super) const CHECK: Check = Check {
    id: "mass",
    looks_at: "the mass over the area of the outline",
    names: "a mass in g",
    find: Find::Other(find),
};

/// Mass over area of the outline, in kg/m²: a foil, and two meters of steel.
const LOADS: (f64, f64) = (0.05, 16e3);

fn find(scene: &Scene<'_>, _: Option<&View>) -> Option<Suspicion> {
    let objects = || scene.recordings.iter().map(|one| &one.object);
    let load = load(scene)?;
    let mass = quantile(objects().map(|one| one.mass).collect(), 0.5)?;
    if is_possible(scene) != Some(false) {
        return None;
    }
    let how = if load > LOADS.1 { "in g, not kg" } else { "1000 times too small" };
    Some(Suspicion {
        what: format!("the mass is {how}"),
        evidence: format!(
            "{mass} kg on an outline with a radius of {} are {load:.1e} kg/m²; steel of 10 mm has \
             79 kg/m²",
            length(scene.size())
        ),
        fix: "correct object.mass_kg in the manifest".into(),
        is_certain: true,
    })
}

/// Whether the mass can be as stated; none without recordings.
pub(super) fn is_possible(scene: &Scene<'_>) -> Option<bool> {
    load(scene).map(|load| (LOADS.0..LOADS.1).contains(&load))
}

/// Typical mass over area, in kg/m².
fn load(scene: &Scene<'_>) -> Option<f64> {
    let objects = scene.recordings.iter().map(|one| &one.object);
    quantile(objects.map(|one| one.mass / one.shape.area()).collect(), 0.5)
}
