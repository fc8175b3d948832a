//! Whether times, lengths and masses are of a size that pushes on a table have.

use dataset::Recording;

use super::mistake::View;
use super::numbers::{length, quantile, speed};
use super::{Scene, Suspicion};

/// Speeds of a pusher, in m/s: beyond these is no quasi-static push nor a robot's.
const SPEEDS: (f64, f64) = (1e-6, 3.0);
/// Speeds that pushes usually have, in m/s.
const USUAL_SPEEDS: (f64, f64) = (2e-4, 3.0);
/// Intervals between samples, in s, beyond which no motion is followed, or no tracker samples.
const INTERVALS: (f64, f64) = (2e-5, 0.4);
/// Mass over area of the outline, in kg/m²: a foil, and two meters of steel.
const LOADS: (f64, f64) = (0.05, 16e3);

/// The median interval between the samples of the object, in s.
pub(super) fn sampling_interval(recording: &Recording) -> Option<f64> {
    let mut t = recording.object.t.clone();
    t.sort_by(f64::total_cmp);
    let intervals = t.windows(2).map(|pair| pair[1] - pair[0]).filter(|interval| *interval > 0.0);
    quantile(intervals.collect(), 0.5)
}

/// Whether times are in another unit: rate and speeds are off together.
pub(super) fn clock(scene: &Scene, intervals: &mut Vec<f64>) -> Option<Suspicion> {
    let interval = quantile(std::mem::take(intervals), 0.5)?;
    let pushed = pusher_speed(scene)?;
    let is_slow = interval > INTERVALS.1 && pushed < USUAL_SPEEDS.0;
    let is_fast = interval < INTERVALS.0 && pushed > USUAL_SPEEDS.1;
    let (what, scale) = match (is_slow, is_fast) {
        (true, _) => ("the times are in ms, not s", "1e-3"),
        (_, true) => ("the times are 1000 times too small", "1e3"),
        _ => return None,
    };
    Some(Suspicion {
        what: what.into(),
        evidence: format!(
            "the object is sampled every {interval:.1e} s, and the pusher moves at {}",
            speed(pushed)
        ),
        fix: format!("set t with scale = {scale} under streams.*.columns (or fields)"),
        is_certain: true,
    })
}

/// Whether all lengths are in another unit, so that they fit each other.
pub(super) fn lengths(scene: &Scene, view: Option<&View>) -> Option<Suspicion> {
    if view?.is_unit {
        return None;
    }
    let pushed = pusher_speed(scene)?;
    let is_large = pushed > SPEEDS.1;
    if !is_large && pushed >= SPEEDS.0 {
        return None;
    }
    let how = if is_large { "in mm, not m" } else { "1000 times too small" };
    Some(Suspicion {
        what: format!("all lengths are {how}"),
        evidence: format!(
            "the pusher moves at {}, and the object has a radius of {}",
            speed(pushed),
            length(scene.size())
        ),
        fix: "correct [object] and pusher.radius_m, and x and y under streams.robot and \
              streams.object"
            .into(),
        is_certain: true,
    })
}

/// Whether the mass is one that the outline can have.
pub(super) fn mass(scene: &Scene) -> Option<Suspicion> {
    let loads = scene.objects.iter().map(|object| object.mass / object.shape.area());
    let load = quantile(loads.collect(), 0.5)?;
    let mass = quantile(scene.objects.iter().map(|object| object.mass).collect(), 0.5)?;
    if (LOADS.0..LOADS.1).contains(&load) {
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

/// The pusher's median speed while the object moves, in m/s.
fn pusher_speed(scene: &Scene) -> Option<f64> {
    let of = |moment: &super::Moment| {
        (moment.pusher[2] - moment.pusher[0]).norm() / (moment.t[2] - moment.t[0])
    };
    quantile(scene.seen.iter().map(|(_, moment)| of(moment)).collect(), 0.5)
}
