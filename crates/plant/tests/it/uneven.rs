//! An object that stands on few spots of an uneven table.

use crate::rig::{push, square};
use nalgebra::Vector2;
use planar::Pose;
use plant::{Burr, PlantError, Texture, Trajectory, Truth, Variation};

fn run(truth: &Truth, start: &Pose, y: f64, angle: f64) -> Trajectory {
    let mut path = push(y, angle, 0.02, 0.03);
    path.start = (Vector2::from(path.start) + start.position).into();
    square(truth).push(start, &path, &Variation::default()).expect("a push")
}

fn on_a_stiff_table() -> Truth {
    let mut truth = Truth::default();
    truth.underside.stiffness = 1e6;
    truth
}

/// Bumps of table, bottom and side, and friction that varies.
fn rough() -> Truth {
    let mut truth = on_a_stiff_table();
    truth.texture_seed = 3;
    truth.tip.height = 0.01;
    truth.height_map.texture = Texture { sd: 2e-5, ..Texture::default() };
    truth.underside.texture = Texture { sd: 1e-5, ..Texture::default() };
    truth.friction_map.texture = Texture { sd: 0.2, ..Texture::default() };
    truth.tip_friction.texture = Texture { sd: 0.2, ..Texture::default() };
    truth
}

#[test]
fn a_flat_bottom_on_a_flat_table_is_pushed_as_if_the_load_were_told() {
    let start = Pose::default();
    let told = run(&Truth::default(), &start, 0.02, 0.3).end_pose();
    let found = run(&on_a_stiff_table(), &start, 0.02, 0.3).end_pose();
    assert!((told.position - found.position).norm() < 1e-8 && told.angle.abs() > 0.1);
    assert!((told.angle - found.angle).abs() < 1e-7);
}

#[test]
fn a_twisted_bottom_and_its_mirror_image_move_in_a_mirror() {
    let end = |side: f64| {
        let mut truth = on_a_stiff_table();
        truth.underside.twist = side * 5e-5;
        truth.underside.hollow = 1e-5;
        truth.body.center_shift = [0.004, side * 0.006];
        truth.tip.height = 0.01;
        run(&truth, &Pose::default(), side * 0.015, side * 0.2).end_pose()
    };
    let (left, right) = (end(1.0), end(-1.0));
    assert!((left.position - Vector2::new(right.position.x, -right.position.y)).norm() < 1e-8);
    assert!((left.angle + right.angle).abs() < 1e-7 && left.angle.abs() > 0.01);
}

#[test]
fn work_goes_into_heat_and_places_differ() {
    let ends: Vec<Pose> = [0.0, 0.01, 0.02, 0.03]
        .into_iter()
        .map(|x| {
            let start = Pose::new(x, 0.0, 0.0);
            let motion = run(&rough(), &start, 0.0, 0.0);
            assert_eq!(motion, run(&rough(), &start, 0.0, 0.0));
            let energy = motion.energy();
            assert!(energy.residual().abs() < 1e-3 * energy.pusher_work, "{energy:?}");
            Pose::new(motion.end_pose().position.x - x, motion.end_pose().position.y, 0.0)
        })
        .collect();
    for pair in ends.windows(2) {
        assert!((pair[0].position - pair[1].position).norm() > 5e-5);
    }
}

#[test]
fn a_hollow_bottom_turns_less_than_a_bulging_one() {
    let turn = |hollow: f64| {
        let mut truth = on_a_stiff_table();
        truth.underside.hollow = hollow;
        run(&truth, &Pose::default(), 0.03, 0.0).end_pose().angle.abs()
    };
    // The load at the rim resists turning with a longer arm.
    assert!(turn(2e-5) < turn(0.0) && turn(0.0) < turn(-2e-5));
}

#[test]
fn a_tip_too_high_tips_the_object_over() {
    let mut truth = on_a_stiff_table();
    truth.tip.height = 0.5;
    let path = push(0.0, 0.0, 0.02, 0.03);
    let error = square(&truth).push(&Pose::default(), &path, &Variation::default()).unwrap_err();
    assert!(
        matches!(error, PlantError::NotConverged { why: "the object tips over", .. }),
        "{error}"
    );
}

#[test]
fn a_tip_at_a_burr_is_caught() {
    let slip = |friction: f64| {
        let mut truth = Truth::default();
        truth.wear.burr = Burr { n_vertices: 3, friction, reach: 0.005 };
        // Towards vertex 1, the upper end of the left edge.
        let motion = run(&truth, &Pose::default(), 0.042, -0.9);
        let tip = |time: f64| motion.pose_at(time).inverse_transform_point(&motion.tip_at(time));
        let touch = motion.first_touch().expect("a touch");
        (tip(touch + 0.5) - tip(touch)).norm()
    };
    assert!(slip(0.0) > 0.002 && slip(2.0) < 0.5 * slip(0.0), "{} {}", slip(0.0), slip(2.0));
}

#[test]
fn the_friction_that_a_table_has_on_average_is_what_warms_it() {
    let along = |sd: f64| {
        let mut truth = Truth { texture_seed: 3, ..Truth::default() };
        truth.friction_map.texture = Texture { sd, ..Texture::default() };
        let motion = run(&truth, &Pose::default(), 0.0, 0.0);
        (motion.table_friction(), motion.energy().support_heat)
    };
    let (even, heat) = along(0.0);
    assert_eq!(even, 1.0);
    for sd in [0.2, 0.4] {
        let (rough, warmer) = along(sd);
        assert!((rough - 1.0).abs() > 0.02 && (warmer / heat / rough - 1.0).abs() < 0.01);
    }
}
