//! What the rig has done, and may be asked to do.

use super::SuggestSettings;
use crate::Observations;
use crate::data::coverage::Coverage;
use crate::data::steady_ingest::{FIRST_WAY, STEP_WAY};
use dataset::quantile;

/// Limits of pushes.
#[derive(Clone, Debug)]
pub(super) struct Reach {
    /// Of the body's origin along x and y, in m.
    pub(super) area: [[f64; 2]; 2],
    /// In m/s.
    pub(super) speeds: Vec<f64>,
    /// In m.
    pub(super) travel: f64,
    /// In m.
    pub(super) pusher_radius: f64,
    /// Whether the object's poses before and after a push are all that is recorded of it.
    pub(super) is_of_ends: bool,
}

/// Steps of a push that is worth doing.
pub(super) const FEWEST_STEPS: usize = 4;
/// Way that holds them behind the first touch, in m, unless a push is fast.
pub(super) const SHORTEST_WAY: f64 = FIRST_WAY + FEWEST_STEPS as f64 * STEP_WAY;
/// Of any rig, in m/s.
const SPEEDS: [f64; 2] = [0.005, 0.5];
/// The longest way that is usual, in m.
const LONGEST: f64 = 0.1;

impl Reach {
    /// What the set has covered, where the settings say nothing else.
    pub(super) fn of(observations: &Observations, settings: &SuggestSettings) -> Self {
        let coverage = Coverage::of(observations);
        let mut ends = coverage.table;
        for (index, step) in observations.steps.iter().enumerate() {
            let along = step.input.direction_w();
            let [dx, dy] =
                [0, 1].map(|k| observations.steps[index].observed[k].unwrap_or_default());
            let end = step.input.pose_wb.position + dx * along + dy * planar::perpendicular(&along);
            for (axis, [low, high]) in ends.iter_mut().enumerate() {
                (*low, *high) = (low.min(end[axis]), high.max(end[axis]));
            }
        }
        let side = ends.iter().map(|[low, high]| high - low).fold(0.0, f64::max);
        let square = ends.map(|[low, high]| {
            let middle = 0.5 * (low + high);
            [middle - 0.5 * side, middle + 0.5 * side]
        });
        let [slowest, fastest] = coverage.speed;
        let usual = [0.5 * slowest, (slowest * fastest).sqrt(), 2.0 * fastest];
        let usual = usual.map(|speed| (1e3 * speed.clamp(SPEEDS[0], SPEEDS[1])).round() / 1e3);
        Self {
            area: settings.area.unwrap_or(square),
            speeds: if settings.speeds.is_empty() {
                usual.to_vec()
            } else {
                settings.speeds.clone()
            },
            travel: settings.travel.unwrap_or_else(|| usual_travel(observations)),
            pusher_radius: observations.steps[0].input.pusher_radius,
            is_of_ends: observations.places[0].is_whole,
        }
    }
}

/// The median way of a push, in whole mm.
fn usual_travel(observations: &Observations) -> f64 {
    // Steps begin behind the first touch, a whole push before it.
    let first = if observations.places[0].is_whole { 0.0 } else { FIRST_WAY };
    let mut ways = vec![first; observations.pushes.len()];
    for (step, push) in observations.push_of.iter().enumerate() {
        ways[*push] += observations.way(step);
    }
    let usual = quantile(ways, 0.5).unwrap_or_default();
    (1e3 * usual.clamp(SHORTEST_WAY, LONGEST)).round() / 1e3
}
