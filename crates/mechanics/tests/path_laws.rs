//! Laws and known answers of a push along a path.
#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

use mechanics::{
    Ellipsoid, PathMotion, PathSettings, Place, Polyline, Pusher, PusherPath, Slider, SmoothPath,
    StraightPath, push_along,
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

/// A direct midpoint rule with a fixed step that restarts the gap at zero, as an oracle.
fn midpoint(path: &StraightPath, n_steps: usize) -> Pose {
    let shape = Shape::square(SIDE).unwrap();
    let surface = Ellipsoid::new(2.0, 2.0 * 0.3826 * SIDE).unwrap();
    let slider = Slider { shape: &shape, surface: &surface, pose_bs: Pose::default() };
    let velocity = |time: f64, pose: &Pose| {
        let center = path.start_w + time * path.velocity_w;
        let contact = slider.contact(&PUSHER, pose, &center);
        let push = slider.push_at(&PUSHER, pose, &contact, &path.velocity_w);
        slider.velocity(&push, pose).unwrap().1
    };
    let moved = |pose: &Pose, h: f64, at: &Pose, time: f64| {
        let twist = velocity(time, at);
        Pose { position: pose.position + h * twist.linear, angle: pose.angle + h * twist.angular }
    };
    let h = path.duration / n_steps as f64;
    (0..n_steps).fold(ORIGIN, |pose, i| {
        let time = i as f64 * h;
        let half = moved(&pose, 0.5 * h, &pose, time);
        moved(&pose, h, &half, time + 0.5 * h)
    })
}

#[test]
fn the_path_agrees_with_a_plain_midpoint_rule_across_switches() {
    for (y, angle) in [(0.01, 0.0), (-0.03, 0.5), (0.044, -0.3), (0.02, 1.0), (-0.02, 0.2)] {
        let path = straight(y, angle, 0.1, 0.3);
        let (ours, theirs) = (default_run(&path).pose_wb, midpoint(&path, 20_000));
        let error = (ours.position - theirs.position).norm();
        assert!(error < 1e-7, "{y} {angle}: {error:e} m");
        assert!((ours.angle - theirs.angle).abs() < 1e-6, "{y} {angle}");
    }
}

#[test]
fn the_object_rests_until_the_pusher_arrives() {
    let touching = straight(0.02, 0.1, 0.02, 0.2);
    let lead = 0.5;
    let early = StraightPath {
        start_w: touching.start_w - lead * touching.velocity_w,
        duration: touching.duration + lead,
        ..touching
    };
    let (late, early) = (default_run(&touching), default_run(&early));
    assert!((early.contact_span().unwrap().0 - lead).abs() < 1e-7);
    assert!((late.pose_wb.position - early.pose_wb.position).norm() < 1e-8);
    assert!((late.pose_wb.angle - early.pose_wb.angle).abs() < 1e-7);
}

#[test]
fn a_pusher_that_passes_by_moves_nothing() {
    let path = StraightPath {
        start_w: Vector2::new(-0.1, 0.06),
        velocity_w: Vector2::new(0.1, 0.0),
        duration: 2.0,
    };
    let motion = default_run(&path);
    assert_eq!((motion.pose_wb, motion.contact_span()), (ORIGIN, None));
    assert_eq!((motion.contact_time, motion.mean_normal_force, motion.slip), (0.0, 0.0, 0.0));
}

#[test]
fn a_pusher_that_turns_back_leaves_the_object_where_it_was() {
    let start = Vector2::new(-0.5 * SIDE - PUSHER.radius, 0.01);
    let there = start + Vector2::new(0.004, 0.0);
    let path = Polyline::new(&[(3.0, start), (3.2, there), (3.4, start)]).unwrap();
    let motion = default_run(&path);
    let pushed = default_run(&straight(0.01, 0.0, 0.02, 0.2));
    assert!((motion.pose_wb.position - pushed.pose_wb.position).norm() < 1e-12);
    assert!((motion.contact_span().unwrap().1 - 0.2).abs() < 1e-12);
    assert!(motion.contact.gap > 0.003);
}

#[test]
fn a_pusher_slides_off_over_the_vertex_and_the_object_stays_behind() {
    let motion = default_run(&straight(0.04, 1.2, 0.05, 1.0));
    let places: Vec<Place> = motion.phases.iter().map(|phase| phase.place).collect();
    assert!(places.contains(&Place::Edge(1)) && places.contains(&Place::Vertex(1)), "{places:?}");
    assert!(motion.contact_span().unwrap().1 < 1.0 && motion.contact.gap > 0.001);
    assert!(motion.slip > 0.004);
}

#[test]
fn a_push_in_two_halves_is_the_whole_push() {
    let whole = straight(0.015, 0.3, 0.05, 0.4);
    let first = StraightPath { duration: 0.2, ..whole };
    let half = default_run(&first).pose_wb;
    let second = StraightPath { start_w: whole.start_w + 0.2 * whole.velocity_w, ..first };
    let joined = run(&second, &PUSHER, &half, &PathSettings::default()).pose_wb;
    let expected = default_run(&whole).pose_wb;
    assert!((joined.position - expected.position).norm() < 1e-8);
    assert!((joined.angle - expected.angle).abs() < 1e-7);
}

#[test]
fn a_smooth_path_that_is_straight_gives_the_straight_push() {
    let path = straight(0.015, 0.3, 0.05, 0.2);
    let smooth = SmoothPath {
        position_w: |time: f64| path.start_w + time * path.velocity_w,
        velocity_w: |_: f64| path.velocity_w,
        duration: path.duration,
    };
    assert_eq!(default_run(&smooth), default_run(&path));
}

#[test]
fn the_gap_stays_closed_while_they_touch() {
    let motion = default_run(&straight(0.02, 0.2, 0.05, 0.5));
    assert!(motion.samples.last().unwrap().touching);
    assert!(motion.contact.gap.abs() < 1e-12);
}

#[test]
fn paths_and_pushers_out_of_range_are_refused() {
    let at = |x: f64| Vector2::new(x, 0.0);
    let refused = |points: &[(f64, Vector2<f64>)]| Polyline::new(points).unwrap_err().to_string();
    assert_eq!(
        refused(&[(0.0, at(0.0))]),
        "point 1 of the pusher's path: a path needs at least two points"
    );
    assert_eq!(
        refused(&[(0.0, at(0.0)), (0.0, at(1.0))]),
        "point 1 of the pusher's path: its time must be later than the one before"
    );
    let shape = Shape::square(SIDE).unwrap();
    let surface = Ellipsoid::new(2.0, 0.08).unwrap();
    let slider = Slider { shape: &shape, surface: &surface, pose_bs: Pose::default() };
    let pusher = Pusher { radius: -0.001, friction: 0.3 };
    let path = straight(0.0, 0.0, 0.02, 0.2);
    let error = push_along(&slider, &pusher, &path, &ORIGIN, &PathSettings::default()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "the pusher's radius must be finite and not negative, got -0.001 m"
    );
}
