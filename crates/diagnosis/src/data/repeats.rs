//! Pushes that repeat each other.

use std::collections::HashMap;

use nalgebra::Vector2;
use planar::wrap_angle;

use crate::{Covariate, Observations};

/// Repeats beyond the first of their cells that a floor needs: fewer leave it open within a factor
/// of two.
pub(crate) const FEWEST_REPEATS: usize = 4;

/// How much two pushes may differ and still count as repeats.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RepeatTolerance {
    /// Of the object's place on the table and of the pusher's on the object, in m.
    pub distance: f64,
    /// Of the object's orientation and of the pusher's direction, in rad.
    pub angle: f64,
    /// Of the pusher's speed, relative.
    pub speed: f64,
}

impl Default for RepeatTolerance {
    /// 3 mm, 3° and 5 %: what differs within it shows in the prediction, too, and cancels.
    fn default() -> Self {
        Self { distance: 3e-3, angle: 0.05, speed: 0.05 }
    }
}

/// Start of a push.
struct Start {
    step: u32,
    place_w: Vector2<f64>,
    yaw: f64,
    pusher_b: Vector2<f64>,
    direction: f64,
    speed: f64,
}

/// The cell of repeats of each push; pushes alone have a cell of their own, and all have where it is
/// not known where the object stood: pushes that look alike need not be repeats.
pub(crate) fn cells(observations: &Observations, tolerance: &RepeatTolerance) -> Vec<usize> {
    if !observations.knows(Covariate::TableX) {
        return (0..observations.pushes.len()).collect();
    }
    let mut starts: Vec<Option<Start>> = observations.pushes.iter().map(|_| None).collect();
    for (index, push) in observations.push_of.iter().enumerate() {
        starts[*push].get_or_insert_with(|| start(observations, index));
    }
    // The first pushes of cells by squares of the table: a repeat is in the same or the next one.
    let mut first_in: HashMap<(i64, i64), Vec<usize>> = HashMap::new();
    let mut cells: Vec<usize> = Vec::new();
    for (push, start) in starts.iter().enumerate() {
        let Some(start) = start else {
            cells.push(push);
            continue;
        };
        let square = |x: f64| (x / tolerance.distance).floor() as i64;
        let (x, y) = (square(start.place_w.x), square(start.place_w.y));
        let around = (x - 1..=x + 1).flat_map(|x| (y - 1..=y + 1).map(move |y| (x, y)));
        let near = around.filter_map(|square| first_in.get(&square)).flatten().copied();
        let is_same = |first: &usize| {
            starts[*first].as_ref().is_some_and(|first| are_same(first, start, tolerance))
        };
        let first = near.filter(is_same).min();
        if first.is_none() {
            first_in.entry((x, y)).or_default().push(push);
        }
        cells.push(first.unwrap_or(push));
    }
    cells
}

fn start(observations: &Observations, index: usize) -> Start {
    let (step, place) = (&observations.steps[index].input, &observations.places[index]);
    let velocity = step.track.mean_velocity();
    Start {
        step: place.step,
        place_w: step.pose_wb.position,
        yaw: step.pose_wb.angle,
        pusher_b: step.pose_wb.inverse_transform_point(&step.track.start()),
        direction: velocity.y.atan2(velocity.x),
        speed: place.speed,
    }
}

fn are_same(a: &Start, b: &Start, tolerance: &RepeatTolerance) -> bool {
    let RepeatTolerance { distance, angle, speed } = *tolerance;
    a.step == b.step
        && (a.place_w - b.place_w).norm() <= distance
        && (a.pusher_b - b.pusher_b).norm() <= distance
        && wrap_angle(a.yaw - b.yaw).abs() <= angle
        && wrap_angle(a.direction - b.direction).abs() <= angle
        && (a.speed - b.speed).abs() <= speed * a.speed.max(b.speed)
}
