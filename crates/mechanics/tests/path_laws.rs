//! Laws and known answers of a push along a path.
#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

use mechanics::{
    Ellipsoid, PathMotion, PathSettings, Place, Pusher, PusherPath, Slider, StraightPath,
    push_along,
};
use nalgebra::Vector2;
use planar::{Pose, Shape};

const SIDE: f64 = 0.09;
const PUSHER: Pusher = Pusher { radius: 0.00475, friction: 0.25 };
const ORIGIN: Pose = Pose { position: Vector2::new(0.0, 0.0), angle: 0.0 };

fn run(
    path: &dyn PusherPath,
    pusher: &Pusher,
    start: &Pose,
    settings: &PathSettings,
) -> PathMotion {
    let shape = Shape::square(SIDE).unwrap();
    let surface = Ellipsoid::new(2.0, 2.0 * 0.3826 * SIDE).unwrap();
    let slider = Slider { shape: &shape, surface: &surface, pose_bs: Pose::default() };
    push_along(&slider, pusher, path, start, settings).unwrap()
}

/// A push on the square's left side, from touch, at `angle` to its normal.
fn straight(y: f64, angle: f64, speed: f64, duration: f64) -> StraightPath {
    StraightPath {
        start_w: Vector2::new(-0.5 * SIDE - PUSHER.radius, y),
        velocity_w: speed * Vector2::new(angle.cos(), angle.sin()),
        duration,
    }
}

fn default_run(path: &dyn PusherPath) -> PathMotion {
    run(path, &PUSHER, &ORIGIN, &PathSettings::default())
}

#[test]
fn a_push_through_the_center_carries_the_object_straight() {
    let motion = default_run(&straight(0.0, 0.0, 0.02, 0.2));
    assert!((motion.pose_wb.position - Vector2::new(0.004, 0.0)).norm() < 1e-12);
    assert!(motion.pose_wb.angle.abs() < 1e-12);
    assert_eq!(motion.phases.len(), 1);
    assert!((motion.mean_normal_force - 2.0).abs() < 1e-12);
    assert!((motion.contact_time - 0.2).abs() < 1e-12);
}

#[test]
fn a_push_left_of_the_center_turns_the_object_clockwise() {
    let motion = default_run(&straight(0.0225, 0.0, 0.02, 0.2));
    assert!(motion.pose_wb.angle < -0.02, "{motion:?}");
    assert_eq!(motion.phases[0].place, Place::Edge(1));
}

/// Errors of the default settings against a thousandfold finer run, in m and rad.
fn error_of_default(path: &dyn PusherPath) -> (f64, f64) {
    let coarse = default_run(path).pose_wb;
    let settings = PathSettings { tolerance: 1e-12, max_travel: 2.5e-4 };
    let fine = run(path, &PUSHER, &ORIGIN, &settings).pose_wb;
    ((coarse.position - fine.position).norm(), (coarse.angle - fine.angle).abs())
}

#[test]
fn the_default_step_is_right_to_a_micrometer_and_ten_microradians() {
    for y in [-0.044, -0.03, -0.011, 0.0, 0.02, 0.0449] {
        for angle in [-1.2, -0.6, -0.25, 0.0, 0.2, 0.7, 1.3] {
            let (position, turn) = error_of_default(&straight(y, angle, 0.02, 0.2));
            assert!(position < 1e-6 && turn < 1e-5, "{y} {angle}: {position:e} m, {turn:e} rad");
            let (position, turn) = error_of_default(&straight(y, angle, 0.1, 0.5));
            assert!(position < 1e-6 && turn < 1e-5, "{y} {angle}: {position:e} m, {turn:e} rad");
        }
    }
}
