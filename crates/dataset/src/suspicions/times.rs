//! Whether times are in another unit: rate and speeds are off together.

use super::numbers::speed;
use super::scene::Scene;
use super::{Check, Find, Suspicion};
use crate::curves::sample::quantile;

pub(super) const CHECK: Check = Check {
    id: "times",
    looks_at: "the rate of the object's samples and the pusher's speed, which a unit of time changes \
               together",
    names: "times in ms, µs, ns or minutes",
    find: Find::Alone(find),
};

/// Intervals between samples, in s, beyond which no motion is followed, or no tracker samples.
const INTERVALS: (f64, f64) = (2e-5, 0.4);
/// Speeds that pushes usually have, in m/s.
const SPEEDS: (f64, f64) = (2e-4, 3.0);
/// The same of fast pushes in ms: a slow camera on a slow push is neither.
const OF_FAST: (f64, f64) = (1.5, 2e-3);
/// The same of times in minutes: faster than 1.6 kHz, and than most pushes, in s and m/s.
const OF_MINUTES: (f64, f64) = (6e-4, 0.25);

fn find(scene: &Scene<'_>) -> Option<Suspicion> {
    let interval = quantile(scene.intervals.clone(), 0.5)?;
    let pushed = scene.pusher_speed()?;
    let is_slow = |(longest, slowest): (f64, f64)| interval > longest && pushed < slowest;
    let (what, scale) = if is_slow((INTERVALS.1, SPEEDS.0)) || is_slow(OF_FAST) {
        let fits = |(_, scale): &&(&str, f64)| interval * scale <= INTERVALS.1;
        let units = [("ms", 1e-3), ("µs", 1e-6), ("ns", 1e-9)];
        let (unit, scale) = units.iter().find(fits)?;
        (format!("the times are in {unit}, not s"), *scale)
    } else if interval < INTERVALS.0 && pushed > SPEEDS.1 {
        ("the times are 1000 times too small".to_owned(), 1e3)
    } else if interval < OF_MINUTES.0 && pushed > OF_MINUTES.1 {
        ("the times are in minutes, not s".to_owned(), 60.0)
    } else {
        return None;
    };
    Some(Suspicion {
        what,
        evidence: format!(
            "the object is sampled every {interval:.1e} s, and the pusher moves at {}",
            speed(pushed)
        ),
        fix: format!("set t with scale = {scale:e} under streams.*.columns (or fields)"),
        is_certain: true,
    })
}
