//! How accurate the simulation is.

use crate::rig::{push, square_with};
use planar::{MIT_NAMES, Pose, mit_object};
use plant::{Numerics, TipPath, Trajectory, Truth, Variation};

/// A fifth of the noise floor of a motion capture, 0.1 mm and 1 mrad.
const FIFTH_OF_NOISE: f64 = 2e-5;
const FIFTH_OF_YAW_NOISE: f64 = 2e-4;

fn run(path: &TipPath, numerics: &Numerics) -> Trajectory {
    let plant = square_with(&Truth::default(), numerics);
    plant.push(&Pose::default(), path, &Variation::default()).expect("a push")
}

fn cases() -> impl Iterator<Item = TipPath> {
    let places = [(0.0, 0.0), (0.02, 0.2), (0.03, -0.6), (-0.01, 0.35), (0.035, 0.6)];
    let speeds = [0.02, 0.1];
    speeds.into_iter().flat_map(move |speed| {
        places.into_iter().map(move |(y, angle)| push(y, angle, speed, 0.05))
    })
}

#[test]
fn half_the_step_and_twice_the_pads_change_a_push_by_less_than_a_fifth_of_the_noise() {
    let plain = Numerics::default();
    let halved = Numerics {
        tolerance: 0.25 * plain.tolerance,
        longest_step: 0.5 * plain.longest_step,
        ..plain
    };
    let doubled = Numerics { n_pads: 2 * plain.n_pads, ..plain };
    for path in cases() {
        let end = run(&path, &plain).end_pose();
        for finer in [&halved, &doubled] {
            let other = run(&path, finer).end_pose();
            let moved = (other.position - end.position).norm();
            let turned = (other.angle - end.angle).abs();
            assert!(moved < FIFTH_OF_NOISE, "{path:?} {finer:?}: {moved} m");
            assert!(turned < FIFTH_OF_YAW_NOISE, "{path:?} {finer:?}: {turned} rad");
        }
    }
}

#[test]
fn a_fast_push_converges_too() {
    let plain = Numerics::default();
    let finer = Numerics { tolerance: 0.25 * plain.tolerance, longest_step: 2.5e-3, ..plain };
    for speed in [0.2, 0.5] {
        let path = push(0.02, 0.2, speed, 0.05);
        let (end, other) = (run(&path, &plain).end_pose(), run(&path, &finer).end_pose());
        assert!((other.position - end.position).norm() < FIFTH_OF_NOISE, "{speed}");
    }
}

#[test]
fn the_work_of_the_robot_is_found_as_heat_motion_and_bending() {
    for path in cases() {
        let motion = run(&path, &Numerics::default());
        let energy = motion.energy();
        let share = energy.residual().abs() / energy.pusher_work;
        assert!(share < 2e-4, "{path:?}: {share}");
        assert!(energy.support_heat > 0.8 * energy.pusher_work);
    }
}

#[test]
fn every_shape_is_pushed_at_every_speed_with_its_energy_in_balance() {
    for name in MIT_NAMES {
        let object = dataset::ObjectSpec::mit(name).unwrap();
        let rig = plant::Plant::new(&object, &Truth::default(), 9.81, &Numerics::default());
        let rig = rig.unwrap();
        let shape = mit_object(name).unwrap().shape;
        for (k, speed) in [0.01, 0.1, 0.5].into_iter().enumerate() {
            let plan = plant::PlannedPush {
                edge: (k * 7) % shape.n_edges(),
                p: 0.3,
                angle: 0.3,
                speed,
                travel: 0.03,
                place: [0.0; 3],
                session: 0,
                repeat: String::new(),
            };
            let path = plan.path(&shape, crate::rig::RADIUS, 10.0, [0.1, 0.2]);
            let motion = rig.push(&Pose::default(), &path, &Variation::default()).unwrap();
            let energy = motion.energy();
            let share = energy.residual().abs() / energy.pusher_work;
            assert!(motion.first_touch().is_some() && share < 1e-3, "{name} {speed}: {share}");
        }
    }
}
