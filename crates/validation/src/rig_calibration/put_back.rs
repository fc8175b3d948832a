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

#[cfg(test)]
mod tests {
    use nalgebra::{Rotation2, Vector2};
    use planar::Pose;
    use plant::Grain;

    use super::{ALLOWED, SLOT, put_back};

    /// Where a push began that ended too far away to go on from there.
    fn far() -> Pose {
        Pose::new(0.0, -1.01 * ALLOWED, 0.3)
    }

    /// An object at an angle, whose slot is dragged by 150 mm towards the middle from where the object itself
    /// is right behind it, but for a turn about the slot.
    fn behind(angle: f64, turned: f64) -> Pose {
        let slot = Rotation2::new(angle) * SLOT;
        let held = -0.15 * slot.normalize();
        Pose { position: held - Rotation2::new(turned) * slot, angle: angle + turned }
    }

    #[test]
    fn an_object_near_the_middle_stays_and_another_comes_to_it_by_its_slot() {
        let end = Pose::new(0.09, -0.04, 2.0);
        let near = Pose::new(0.99 * ALLOWED, 0.0, 1.0);
        assert_eq!(put_back(&near, &end, &Grain::default()), end);
        let grain = Grain { ratio: 1.3, direction: 0.4 };
        let back = put_back(&far(), &end, &grain);
        assert!(back.transform_point(&SLOT).norm() < 1e-12, "{back:?}");
        assert!(back.position != Vector2::zeros() && back.angle != end.angle);
    }

    #[test]
    fn an_object_right_behind_its_slot_does_not_turn_on_an_even_table() {
        for angle in [-2.0, 0.1, 3.0] {
            let back = put_back(&far(), &behind(angle, 0.0), &Grain::default());
            assert!((back.angle - angle).abs() < 1e-6, "{angle} {back:?}");
            // Neither does it where the grain goes the same way, for that is as even to both sides.
            let along = angle + SLOT.y.atan2(SLOT.x);
            let grain = |direction| Grain { ratio: 1.5, direction };
            let back = put_back(&far(), &behind(angle, 0.0), &grain(along));
            assert!((back.angle - angle).abs() < 1e-6, "{angle} {back:?}");
            let back = put_back(&far(), &behind(angle, 0.0), &grain(along + 0.7));
            assert!((back.angle - angle).abs() > 1e-2, "{angle} {back:?}");
        }
    }

    #[test]
    fn an_object_turns_in_behind_its_slot_alike_from_both_sides() {
        let turned = |by: f64| put_back(&far(), &behind(0.5, by), &Grain::default()).angle - 0.5;
        for by in [0.2, 0.6] {
            let left = turned(by);
            assert!(left > 0.0 && left < 0.5 * by, "{by} {left}");
            assert!((left + turned(-by)).abs() < 1e-6, "{by} {left}");
        }
    }
}
