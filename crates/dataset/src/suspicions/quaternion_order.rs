//! Whether the parts of the object's quaternions are in the order in which they are read.

use super::scene::Scene;
use super::{Check, Find, Suspicion};

pub(super) const CHECK: Check = Check {
    id: "quaternion-order",
    looks_at: "tilt and yaw of the object: about the table's normal it turns, and does not tilt",
    names: "quaternions with w first that are read with w last",
    find: Find::Alone(find),
};

/// Tilt, in rad, that no object on a table has.
const TILT: f64 = 0.3;
/// Yaw, in rad, within which an object that is pushed about stays only by a mistake.
const TURN: f64 = 0.05;
/// Share of the recordings that have to be so.
const SHARE: f64 = 0.8;

/// Of (w, x, y, z) read as (x, y, z, w) a turn by θ about z is one by π − θ about x.
fn find(scene: &Scene<'_>) -> Option<Suspicion> {
    let n = scene.recordings.len();
    let is_so = scene.recordings.iter().filter(|one| one.tilt > TILT && one.turn < TURN).count();
    if n == 0 || (is_so as f64) < SHARE * n as f64 {
        return None;
    }
    let tilt = scene.recordings.iter().map(|one| one.tilt).fold(0.0, f64::max);
    Some(Suspicion {
        what: "the object's quaternions are in another order than x, y, z, w".into(),
        evidence: format!(
            "in {is_so} of {n} recordings the object tilts, by up to {:.0}°, and does not turn about \
             the table's normal",
            tilt.to_degrees()
        ),
        fix: "name the parts under streams.object.columns (or fields): where w comes first, qw is \
              what is called x, qx what is called y, qy z, and qz w"
            .into(),
        is_certain: true,
    })
}
