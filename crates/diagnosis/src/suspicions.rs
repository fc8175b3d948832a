//! Frames, signs and units that recordings cannot have, told by the mechanics.

mod forces;
mod geometry;
mod mistake;
mod moment;
mod numbers;
mod outputs;
mod units;

use std::fmt;

use dataset::{Manifest, Recording};
use serde::Serialize;

pub use self::outputs::step_suspicions;

use self::geometry::geometry;
use self::moment::{Moment, moments};

/// Something about recordings or a step table that cannot be as stated.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Suspicion {
    /// What seems to be wrong.
    pub what: String,
    /// The numbers that say so.
    pub evidence: String,
    /// Which key of the manifest, or of a table's mapping, to correct, and how.
    pub fix: String,
    /// Whether nothing that is read from them can be trusted.
    pub is_certain: bool,
}

impl fmt::Display for Suspicion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { what, evidence, fix, is_certain } = self;
        let how = if *is_certain { "" } else { "perhaps " };
        write!(f, "{how}{what}: {evidence}; {fix}")
    }
}

/// Recordings that are looked at, evenly over a set.
pub const SUSPECTED_RECORDINGS: usize = 40;

/// What of the frames, signs and units of recordings contradicts the mechanics.
///
/// While an object moves, the pusher touches it; it presses, and within the cone of friction; and
/// the force is about that of sliding. What a single mistake of the manifest or of a stream would
/// put right is named as that mistake, and only then: a set in which an effect is hidden, however
/// strong, has none. Recordings of unknown shapes and without motion are passed over.
pub fn suspicions(
    recordings: impl IntoIterator<Item = Recording>,
    manifest: &Manifest,
) -> Vec<Suspicion> {
    let mut seen = Vec::new();
    let mut intervals = Vec::new();
    let mut objects = Vec::new();
    for recording in recordings {
        intervals.extend(units::sampling_interval(&recording));
        let Ok(object) = manifest.object.of(&recording.name) else { continue };
        seen.extend(moments(&recording).into_iter().map(|moment| (objects.len(), moment)));
        objects.push(object);
    }
    let scene = Scene { seen, objects, radius: manifest.pusher.radius };
    let mut found = Vec::new();
    if let Some(clock) = units::clock(&scene, &mut intervals) {
        // Nothing else is as it was.
        return vec![clock];
    }
    let geometry = geometry(&scene);
    found.extend(geometry.suspicion);
    found.extend(units::lengths(&scene, geometry.view.as_ref()));
    let mass = units::mass(&scene);
    let is_mass_known = mass.is_none();
    found.extend(mass);
    if let Some(view) = geometry.view {
        found.extend(forces::direction(&scene, &view));
        found.extend(forces::size(&scene, manifest, is_mass_known));
    }
    found
}

/// All that is looked at.
struct Scene {
    /// Moments in which an object moves, with the index of the object.
    seen: Vec<(usize, Moment)>,
    objects: Vec<dataset::ObjectSpec>,
    /// Of the pusher, in m.
    radius: f64,
}

impl Scene {
    /// Distance from the frame's origin to the farthest vertex of a typical object, in m.
    fn size(&self) -> f64 {
        let radii = self.objects.iter().map(|object| object.shape.bounding_radius());
        numbers::quantile(radii.collect(), 0.5).unwrap_or(0.0)
    }
}
