//! Frames, signs, units and clocks that recordings cannot have, told by the mechanics.
//!
//! In come recordings as read and their manifest; out come the mistakes that would explain what
//! contradicts the mechanics. [`CHECKS`] is the list; each check is one file.

mod exchanged;
mod force_clock;
mod force_direction;
mod force_size;
mod lengths;
mod mass;
mod mistake;
mod moment;
mod numbers;
mod outline;
mod places;
mod quaternion_order;
mod scene;
mod stream_clock;
mod times;
mod track;

use std::fmt;

use crate::{Manifest, Recording};
use serde::{Deserialize, Serialize};

use self::mistake::View;
use self::scene::Scene;

/// Something about recordings or a step table that cannot be as stated.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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

/// One kind of check of recordings against the mechanics.
#[derive(Debug)]
pub struct Check {
    /// Its name.
    pub id: &'static str,
    /// What it looks at, and what of that cannot be.
    pub looks_at: &'static str,
    /// What it names, and what to correct.
    pub names: &'static str,
    find: Find,
}

/// How a check's finding stands to those of others.
#[derive(Debug)]
enum Find {
    /// Nothing else is as it was: the others are not asked.
    Alone(fn(&Scene<'_>) -> Option<Suspicion>),
    /// One explanation of where pusher and object are; the best is told.
    Places(fn(&Scene<'_>) -> Option<Explanation>),
    /// Asked whatever is said of places, as which they are seen.
    Other(fn(&Scene<'_>, Option<&View>) -> Option<Suspicion>),
    /// Asked where pusher and object are where they can be.
    Forces(fn(&Scene<'_>, &View) -> Option<Suspicion>),
}

/// A mistake that would explain where pusher and object are.
struct Explanation {
    /// How far the pusher is from the outline without it, in m.
    distance: f64,
    /// What is said of it; nothing if all is as it must be.
    suspicion: Option<Suspicion>,
    /// As which forces can be looked at.
    view: Option<View>,
}

/// Every check, in the order in which they are asked; of two explanations that are as good the
/// first is told.
pub const CHECKS: &[Check] = &[
    times::CHECK,
    quaternion_order::CHECK,
    places::CHECK,
    exchanged::CHECK,
    stream_clock::CHECK,
    outline::CHECK,
    lengths::CHECK,
    mass::CHECK,
    force_clock::CHECK,
    force_direction::CHECK,
    force_size::CHECK,
];

/// Recordings that are looked at, evenly over a set.
pub const SUSPECTED_RECORDINGS: usize = 40;

/// Another explanation has to bring the pusher nearer by this factor to be preferred.
const AS_GOOD: f64 = 0.5;

/// What of the frames, signs, units and clocks of recordings contradicts the mechanics.
///
/// While an object moves, the pusher touches it; it presses, and within the cone of friction; and
/// the force is about that of sliding. What a single mistake of the manifest or of a stream would
/// put right is named as that mistake, and only then: a set in which an effect is hidden, however
/// strong, has none. Recordings of unknown shapes and without motion are passed over.
pub fn suspicions(
    recordings: impl IntoIterator<Item = Recording>,
    manifest: &Manifest,
) -> Vec<Suspicion> {
    let scene = Scene::of(recordings, manifest);
    for check in CHECKS {
        if let Find::Alone(find) = check.find
            && let Some(found) = find(&scene)
        {
            return vec![found];
        }
    }
    let mut best: Option<Explanation> = None;
    for check in CHECKS {
        if let Find::Places(find) = check.find
            && let Some(found) = find(&scene)
            && best.as_ref().is_none_or(|best| found.distance < AS_GOOD * best.distance)
        {
            best = Some(found);
        }
    }
    let (places, view) = best.map_or((None, None), |best| (best.suspicion, best.view));
    let mut found: Vec<_> = places.into_iter().collect();
    for check in CHECKS {
        found.extend(match (&check.find, &view) {
            (Find::Other(find), view) => find(&scene, view.as_ref()),
            (Find::Forces(find), Some(view)) => find(&scene, view),
            _ => None,
        });
    }
    found
}
