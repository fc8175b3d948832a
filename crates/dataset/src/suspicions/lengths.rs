//! Whether all lengths are in another unit, so that they fit each other.

use super::mistake::View;
use super::numbers::{length, speed};
use super::scene::Scene;
use super::{Check, Find, Suspicion};

pub(super) const CHECK: Check = Check {
    id: "lengths",
    looks_at: "the pusher's speed and the object's size, which a unit of all lengths changes together",
    names: "lengths that are in mm everywhere, or 1000 times too small",
    find: Find::Other(find),
};

/// Speeds of a pusher, in m/s: beyond these is no quasi-static push nor a robot's.
const SPEEDS: (f64, f64) = (1e-6, 3.0);
/// Distance of a vertex from the center, in m, of what no robot pushes over a table.
const LARGEST: f64 = 1.5;

fn find(scene: &Scene<'_>, view: Option<&View>) -> Option<Suspicion> {
    // A unit that is named already explains sizes and speeds, too.
    if view?.is_unit {
        return None;
    }
    let pushed = scene.pusher_speed()?;
    let size = scene.size();
    let (is_fast, is_slow, is_large) = (pushed > SPEEDS.1, pushed < SPEEDS.0, size > LARGEST);
    // What is fast alone, or large alone, is a mistake of one stream.
    if !is_slow && !is_large {
        return None;
    }
    let how = if is_large { "in mm, cm or inches, not m" } else { "1000 times too small" };
    Some(Suspicion {
        what: format!("all lengths are {how}"),
        evidence: format!(
            "the pusher moves at {}, and the object has a radius of {}",
            speed(pushed),
            length(size)
        ),
        fix: "correct [object] and pusher.radius_m, and x and y under streams.robot and \
              streams.object"
            .into(),
        is_certain: is_slow || is_fast,
    })
}
