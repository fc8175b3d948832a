//! How the robot put the object back between repeats of a push.

use nalgebra::{Matrix2, Rotation2, Vector2};
use planar::Pose;
use plant::Grain;

/// Where the robot holds the object when it drags it back, in m and frame B.
const SLOT: Vector2<f64> = Vector2::new(-0.0106, 0.0106);
/// The object stays where it is after a push that began nearer than this to the middle of the table,
/// in m.
const ALLOWED: f64 = 0.06;
/// The object's side, and how many places along it bear it.
const SIDE: f64 = 0.09;
const N_PLACES: usize = 9;
/// Way of the drag after which the object's turn is found anew, in m.
const STEP: f64 = 1e-3;
/// Fastest turn that is looked for, in rad/m, and how often the search is narrowed.
const FASTEST: f64 = 100.0;
const N_NARROWED: usize = 40;

/// Where the object lies for the next push, which leaves how it is turned to the dragging.
///
/// - `start`: where the last push began; - `end`: where it ended.
pub(super) fn put_back(start: &Pose, end: &Pose, grain: &Grain) -> Pose {
    if start.position.norm() <= ALLOWED {
        return *end;
    }
    let held = |pose: &Pose| pose.position + Rotation2::new(pose.angle) * SLOT;
    let from = held(end);
    let direction = -from.normalize();
    let n_steps = (from.norm() / STEP).ceil();
    let mut angle = end.angle;
    for _ in 0..n_steps as usize {
        angle += from.norm() / n_steps * turn(angle, &direction, grain);
    }
    let position = -(Rotation2::new(angle) * SLOT);
    Pose { position, angle }
}

/// Turn over way of an object that is dragged by its slot, in rad/m: that which dissipates least.
fn turn(angle: f64, direction: &Vector2<f64>, grain: &Grain) -> f64 {
    let along = Rotation2::new(grain.direction);
    let metric = along * Matrix2::new(grain.ratio, 0.0, 0.0, 1.0 / grain.ratio) * along.inverse();
    let place = |k: usize| ((k as f64 + 0.5) / N_PLACES as f64 - 0.5) * SIDE;
    let arms: Vec<Vector2<f64>> = (0..N_PLACES * N_PLACES)
        .map(|k| {
            Rotation2::new(angle) * (Vector2::new(place(k % N_PLACES), place(k / N_PLACES)) - SLOT)
        })
        .collect();
    let dissipated = |turn: f64| -> f64 {
        let velocity = |arm: &Vector2<f64>| direction + turn * Vector2::new(-arm.y, arm.x);
        arms.iter().map(velocity).map(|v| v.dot(&(metric * v)).sqrt()).sum()
    };
    // It is convex in the turn.
    let (mut low, mut high) = (-FASTEST, FASTEST);
    for _ in 0..N_NARROWED {
        let third = (high - low) / 3.0;
        if dissipated(low + third) < dissipated(high - third) {
            high -= third;
        } else {
            low += third;
        }
    }
    0.5 * (low + high)
}
