//! Laws of motion that hold for any push.

use crate::rig::{RADIUS, push, square};
use nalgebra::{Rotation2, Vector2};
use planar::Pose;
use plant::{FrictionMap, Grain, Plant, PlantError, TipPath, Truth, Variation};

const NONE: Variation = Variation {
    support_friction: 1.0,
    tip_friction: 1.0,
    pressure_radius: 1.0,
    pressure_shift: [0.0; 2],
    contact_shift: 0.0,
    force_bias: [0.0; 2],
    zero_kept: 1.0,
    gap: 0.0,
    shift: [0.0; 2],
};

fn run(plant: &Plant, path: &TipPath) -> plant::Trajectory {
    plant.push(&Pose::default(), path, &NONE).expect("a push")
}

/// A truth without any symmetry; `side` is 1, or −1 for its mirror image.
fn lopsided(side: f64) -> Truth {
    let mut truth = Truth::default();
    truth.pressure.center_shift = [0.006, side * 0.004];
    truth.body.center_shift = [0.006, side * 0.004];
    truth.table_grain = Grain { ratio: 1.3, direction: side * 0.6 };
    truth.body_grain = Grain { ratio: 1.2, direction: side * 1.1 };
    truth.friction_map = FrictionMap { gradient: [2.0, side * 3.0], ..FrictionMap::default() };
    truth.height_map.downhill = [0.1, side * 0.2];
    truth.tip_friction.asymmetry = side * 0.3;
    truth.tip.bias = side * 0.001;
    truth
}

#[test]
fn a_mirrored_truth_and_push_give_a_mirrored_motion() {
    for (y, angle, speed) in [(0.02, 0.3, 0.02), (-0.01, -0.7, 0.2)] {
        let left = run(&square(&lopsided(1.0)), &push(y, angle, speed, 0.03));
        let right = run(&square(&lopsided(-1.0)), &push(-y, -angle, speed, 0.03));
        let (a, b) = (left.end_pose(), right.end_pose());
        assert!((a.position - Vector2::new(b.position.x, -b.position.y)).norm() < 1e-8);
        assert!((a.angle + b.angle).abs() < 1e-7);
        assert!(a.angle.abs() > 0.01);
    }
}

#[test]
fn a_turned_scene_on_an_even_table_moves_alike() {
    let plant = square(&Truth::default());
    let path = push(0.02, 0.3, 0.1, 0.03);
    let plain = run(&plant, &path).end_pose();
    let turn = Rotation2::new(1.1);
    let away = Vector2::new(0.2, -0.1);
    let turned_path = TipPath {
        start: (away + turn * Vector2::from(path.start)).into(),
        direction: (turn * Vector2::from(path.direction)).into(),
        ..path
    };
    let start = Pose::new(away.x, away.y, 1.1);
    let turned = plant.push(&start, &turned_path, &NONE).unwrap().end_pose();
    assert!((turned.position - away - turn * plain.position).norm() < 1e-8);
    assert!((turned.angle - 1.1 - plain.angle).abs() < 1e-7);
}

#[test]
fn the_size_of_the_friction_leaves_a_slow_motion_and_scales_its_force() {
    let stiff = |friction: f64| {
        let mut truth = Truth::default();
        truth.support_friction.coefficient = friction;
        truth.tip.compliance = 1e-6;
        run(&square(&truth), &push(0.02, 0.3, 0.004, 0.01))
    };
    let (weak, strong) = (stiff(0.2), stiff(0.4));
    let moved = weak.end_pose().position - strong.end_pose().position;
    // The tip gives way by 1 µm for each of the 1.6 N between them, and an object that was hit at
    // 4 mm/s slides ahead by v²/2μg = 4 µm and 2 µm.
    assert!(moved.norm() < 4e-6, "{moved}");
    assert!((weak.end_pose().angle - strong.end_pose().angle).abs() < 1e-4);
    let force = |push: &plant::Trajectory| push.mean_force(2.0, 3.0).norm();
    let ratio = force(&strong) / force(&weak);
    assert!((ratio - 2.0).abs() < 1e-3, "{ratio}");
}

#[test]
fn a_push_through_the_center_needs_the_whole_friction_and_does_not_turn() {
    let straight = run(&square(&Truth::default()), &push(0.0, 0.0, 0.02, 0.05));
    assert!(straight.end_pose().angle.abs() < 1e-9);
    let expected = 0.25 * 0.8374 * 9.81;
    assert!((straight.mean_force(1.0, 2.0).x / expected - 1.0).abs() < 1e-4);
    assert!((straight.end_pose().position.x - 0.05).abs() < 5e-5);
}

#[test]
fn inside_the_motion_cone_the_tip_sticks_and_outside_it_slides_on_the_friction_cone() {
    let plant = square(&Truth::default());
    let inside = run(&plant, &push(0.0, 0.1, 0.02, 0.02));
    let outside = run(&plant, &push(0.0, 0.9, 0.02, 0.02));
    assert!(inside.energy().slip_heat < 1e-3 * inside.energy().pusher_work);
    assert!(outside.energy().slip_heat > 0.05 * outside.energy().pusher_work);
    let along_edge = |push: &plant::Trajectory, time: f64| {
        let force = Rotation2::new(-push.pose_at(time).angle) * push.force_at(time);
        force.y / force.x
    };
    for time in [0.6, 0.8, 1.0] {
        assert!(along_edge(&inside, time).abs() < 0.24);
        // Pose and force are up to one step of 5 ms apart.
        assert!((along_edge(&outside, time) - 0.25).abs() < 0.003);
    }
}

#[test]
fn an_object_that_is_not_touched_stays_where_it_is_to_the_last_bit() {
    let plant = square(&Truth::default());
    let away = TipPath { direction: [-1.0, 0.0], ..push(0.0, 0.0, 0.1, 0.05) };
    let start = Pose::new(0.0, 0.0, 0.0);
    let motion = plant.push(&start, &away, &NONE).unwrap();
    assert_eq!(motion.end_pose(), start);
    assert_eq!(motion.first_touch(), None);
    assert_eq!(motion.energy().residual(), 0.0);
}

#[test]
fn after_a_sudden_stop_the_object_slides_on_as_friction_alone_brakes_it() {
    for speed in [0.2, 0.4] {
        let mut path = push(0.0, 0.0, speed, 0.2);
        path.acceleration = 50.0;
        let motion = run(&square(&Truth::default()), &path);
        let stop = path.breaks()[2];
        let slide = motion.end_pose().position.x - motion.pose_at(stop).position.x;
        let expected = speed * speed / (2.0 * 0.25 * 9.81);
        assert!((slide / expected - 1.0).abs() < 0.01, "{speed}: {slide} {expected}");
    }
}

#[test]
fn the_tip_does_not_enter_the_object_and_never_pulls() {
    let plant = square(&Truth::default());
    let path = push(0.02, 0.3, 0.1, 0.05);
    let motion = run(&plant, &path);
    for time in motion.times() {
        let pose = motion.pose_at(time);
        let force = Rotation2::new(-pose.angle) * motion.force_at(time);
        assert!(force.x >= -1e-9, "{force}");
        let tip = motion.tip_at(time) + motion.deflection_at(time);
        let tip_b = pose.inverse_transform_point(&tip);
        let gap = -crate::rig::HALF - tip_b.x - crate::rig::RADIUS;
        assert!(gap > -1e-6, "{time} s: {gap} m");
    }
}

#[test]
fn a_tip_that_begins_inside_and_a_path_without_speed_are_refused() {
    let plant = square(&Truth::default());
    let inside = TipPath { start: [-0.046, 0.0], ..push(0.0, 0.0, 0.02, 0.01) };
    let error = plant.push(&Pose::default(), &inside, &NONE).unwrap_err();
    assert!(matches!(error, PlantError::Blocked { depth } if (depth - 0.00375).abs() < 1e-9));
    let still = TipPath { speed: 0.0, ..push(0.0, 0.0, 0.02, 0.01) };
    let error = plant.push(&Pose::default(), &still, &NONE).unwrap_err();
    assert!(error.to_string().contains("its speed = 0 m/s"), "{error}");
    let skewed = TipPath { direction: [1.0, 1.0], ..push(0.0, 0.0, 0.02, 0.01) };
    assert!(plant.push(&Pose::default(), &skewed, &NONE).is_err());
}

#[test]
fn the_torque_on_a_sliding_tip_is_its_radius_times_friction() {
    let plant = square(&Truth::default());
    let path = push(0.0, 1.2, 0.02, 0.03);
    let push = run(&plant, &path);
    // The object turns, so the normal is that of a short time.
    let (from, to) = (1.0, 1.01);
    let turn = push.pose_at(0.5 * (from + to)).angle;
    let force_b = Rotation2::new(-turn) * push.mean_force(from, to);
    assert!(force_b.x > 0.5 && (force_b.y / (0.25 * force_b.x) - 1.0).abs() < 0.01, "{force_b}");
    let expected = -RADIUS * 0.25 * force_b.x;
    let torque = push.mean_torque(from, to);
    assert!((torque / expected - 1.0).abs() < 0.01, "{torque} {expected}");
    let mirrored = run(&plant, &self::push(0.0, -1.2, 0.02, 0.03)).mean_torque(from, to);
    assert!((torque + mirrored).abs() < 1e-6, "{torque} {mirrored}");
}

/// A table that leans by an angle (rad) along −y.
fn tilted(angle: f64) -> Truth {
    let mut truth = Truth::default();
    truth.height_map.downhill = [0.0, -9.81 * angle.sin()];
    truth
}

#[test]
fn an_object_that_nothing_pushes_rests_on_a_tilted_table() {
    let away = TipPath { direction: [-1.0, 0.0], hold: 20.0, ..push(0.0, 0.0, 0.1, 0.05) };
    let start = Pose::new(0.01, -0.02, 0.3);
    // Friction bears atan 0.25 = 14.04°.
    for degrees in [0.5_f64, 2.0, 8.0, 13.0] {
        let plant = square(&tilted(degrees.to_radians()));
        let motion = plant.push(&start, &away, &NONE).unwrap();
        assert_eq!(motion.end_pose(), start, "{degrees}°");
    }
    let steep = square(&tilted(15.0_f64.to_radians()));
    let slid = steep.push(&start, &away, &NONE).unwrap();
    let (time, angle) = (away.duration(), 15.0_f64.to_radians());
    // The weight on the table is that of a level one.
    let acceleration = 9.81 * (angle.sin() - 0.25);
    let expected = 0.5 * acceleration * time * time;
    let way = start.position.y - slid.end_pose().position.y;
    assert!((way / expected - 1.0).abs() < 1e-3, "{way} m, expected {expected} m");
}

#[test]
fn an_object_that_slides_ahead_of_the_tip_comes_to_rest_on_a_tilted_table() {
    let plant = square(&tilted(2.0_f64.to_radians()));
    let path = TipPath { hold: 5.0, ..push(0.01, 0.1, 0.5, 0.05) };
    let motion = plant.push(&Pose::default(), &path, &NONE).unwrap();
    let (end, before) = (path.duration(), path.duration() - 4.0);
    assert!(!motion.touches_at(end));
    assert_eq!(motion.pose_at(end), motion.pose_at(before));
    assert_eq!(motion.motion_at(end), (Vector2::zeros(), 0.0));
    let energy = motion.energy();
    assert!(energy.residual().abs() < 1e-3 * energy.pusher_work, "{energy:?}");
}

/// The bound that the documentation of the creep speed states.
#[test]
fn an_object_that_the_tip_holds_creeps_no_faster_than_stated_and_then_rests() {
    let angle = 2.0_f64.to_radians();
    let plant = square(&tilted(angle));
    let path = TipPath { hold: 5.0, ..push(0.0, 0.0, 0.02, 0.02) };
    let motion = plant.push(&Pose::default(), &path, &NONE).unwrap();
    let (stop, end) = (path.duration() - path.hold, path.duration());
    let step = 0.02;
    let mut n_creeping = 0;
    for k in 1..100 {
        let time = stop + step * f64::from(k);
        let moved = (motion.pose_at(time + step).position - motion.pose_at(time).position).norm();
        // Friction holds the tilt's pull and what is left in the tip's spring.
        let pull = 0.8374 * Vector2::new(0.0, -9.81 * angle.sin()) + motion.force_at(time);
        let share = pull.norm() / (0.25 * 0.8374 * 9.81);
        let creep = plant::Numerics::default().creep * share / (1.0 - share * share).sqrt();
        // It turns a little, and so creeps a little farther from its center.
        assert!(moved <= 1.1 * step * creep, "{time} s: {moved} m, {share} of the limit");
        n_creeping += usize::from(moved > 0.0);
    }
    assert!(n_creeping > 10, "{n_creeping}");
    let (last, before) = (motion.pose_at(end), motion.pose_at(end - 1.0));
    assert!((last.position - before.position).norm() < 1e-15, "{last:?} {before:?}");
    assert!((last.angle - before.angle).abs() < 1e-15, "{last:?} {before:?}");
    let crept = (motion.end_pose().position - motion.pose_at(stop).position).norm();
    let spring = plant.truth().tip.compliance * 0.25 * 0.8374 * 9.81;
    assert!(crept < 1.5 * spring, "{crept} m on a spring that is wound up by {spring} m");
}

#[test]
fn a_tip_may_be_a_point() {
    let with_radius = |radius: f64| {
        let mut truth = Truth::default();
        truth.tip.radius = radius;
        let path = push(0.02, 0.5, 0.02, 0.03);
        // The centers go the same way; the thin tip touches just later.
        let start = Vector2::from(path.start) + Vector2::new(RADIUS, 0.0);
        run(&square(&truth), &TipPath { start: start.into(), ..path }).end_pose()
    };
    let (point, thin) = (with_radius(0.0), with_radius(1e-5));
    assert!((point.position - thin.position).norm() < 2e-5, "{point:?} {thin:?}");
    assert!((point.angle - thin.angle).abs() < 1e-3 && point.angle.abs() > 0.05, "{point:?}");
    let mut truth = Truth::default();
    truth.tip.radius = 0.0;
    // Off the edge over its end.
    let over = run(&square(&truth), &push(0.043, 1.2, 0.05, 0.05)).end_pose();
    assert!(over.position.norm().is_finite());
}
