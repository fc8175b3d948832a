//! A step in the midst of a push begins as fast as the push made the object.

use std::sync::Arc;

use effects::{Object, PushMoment, PushPhysics, Rig, RunUp, StepInput, Surface, Track, by_id};
use nalgebra::Vector2;
use planar::{Pose, Shape, Twist};

const SIDE: f64 = 0.09;
const RADIUS: f64 = 0.005;
/// The pusher's way over a step, in m.
const WAY: f64 = 4e-3;
const N_STEPS: usize = 10;

fn inertia(substep: f64) -> PushPhysics {
    let rig = Rig::new(Surface::Ellipsoid, 0.25, 0.3).unwrap();
    let rig = rig.with_longest_substep(substep).unwrap();
    PushPhysics::new(rig).with(by_id("inertia").unwrap(), &[1.0]).unwrap()
}

/// A push along +x at the left edge of a square at rest, `y` off its middle, as one step.
fn whole_push(y: f64, speed: f64) -> StepInput {
    let shape = Arc::new(Shape::square(SIDE).unwrap());
    let start = Vector2::new(-0.5 * SIDE - RADIUS, y);
    let way = Vector2::new(N_STEPS as f64 * WAY, 0.0);
    StepInput {
        object: Arc::new(Object::uniform(shape, 0.8).unwrap()),
        pusher_radius: RADIUS,
        pose_wb: Pose::default(),
        twist_wb: Twist::default(),
        track: Track::straight(start, start + way, way.norm() / speed),
        touching: true,
        since_contact: 0.0,
        run_up: None,
        progress: 0.5,
        session: 0,
    }
}

/// The whole push in fine sub-steps, as measured moments every 4 mm of the pusher's way.
fn measured(whole: &StepInput, speed: f64) -> Vec<PushMoment> {
    let times: Vec<f64> = (0..=N_STEPS).map(|k| k as f64 * WAY / speed).collect();
    let path = inertia(1e-4).predict_path(whole, &times).unwrap();
    let moment = |(time, pose_wb): (&f64, &Pose)| {
        let (pusher_w, pusher_velocity_w) = whole.track.at(*time);
        PushMoment { since_contact: *time, pose_wb: *pose_wb, pusher_w, pusher_velocity_w }
    };
    times.iter().zip(&path).map(moment).collect()
}

/// The step between two moments of a push.
fn step_of(whole: &StepInput, moments: &[PushMoment], k: usize) -> StepInput {
    let (from, to) = (&moments[k], &moments[k + 1]);
    let duration = to.since_contact - from.since_contact;
    StepInput {
        pose_wb: from.pose_wb,
        track: Track::straight(from.pusher_w, to.pusher_w, duration),
        since_contact: from.since_contact,
        run_up: Some(Arc::new(RunUp::new(moments.to_vec()).unwrap())),
        ..whole.clone()
    }
}

#[test]
fn the_steps_of_a_push_go_as_the_whole_push_does() {
    for speed in [0.02, 0.1, 0.2, 0.4, 1.0] {
        for y in [0.0, 0.01, 0.03] {
            let whole = whole_push(y, speed);
            let moments = measured(&whole, speed);
            for k in 0..N_STEPS {
                let found = inertia(1e-3).predict(&step_of(&whole, &moments, k)).unwrap();
                let (from, to) = (&moments[k].pose_wb, &moments[k + 1].pose_wb);
                let off = Vector2::new(found.dx, found.dy) - (to.position - from.position);
                let turn = found.dtheta - (to.angle - from.angle);
                let context = format!("{speed} m/s, {y} m off the middle, step {k}");
                assert!(off.norm() < 5e-6 && turn.abs() < 1e-4, "{context}: {off} {turn}");
            }
        }
    }
}

#[test]
fn with_a_run_up_the_measured_velocity_tells_nothing() {
    let whole = whole_push(0.02, 0.1);
    let step = step_of(&whole, &measured(&whole, 0.1), 4);
    let moving = StepInput { twist_wb: Twist::new(0.08, 0.03, -2.0), ..step.clone() };
    let predict = |step: &StepInput| inertia(1e-3).predict(step).unwrap();
    assert_eq!(predict(&moving), predict(&step));
    let alone = |step: &StepInput| predict(&StepInput { run_up: None, ..step.clone() });
    assert!((alone(&moving).dtheta - alone(&step).dtheta).abs() > 1e-3);
}

#[test]
fn a_run_up_refuses_what_is_no_push() {
    let whole = whole_push(0.02, 0.1);
    let good = measured(&whole, 0.1);
    let refused = |moments: Vec<PushMoment>| RunUp::new(moments).unwrap_err().to_string();
    assert!(refused(Vec::new()).contains("at least one"));
    let twice = refused(vec![good[1], good[1]]);
    assert!(twice.contains("later than the moment before"), "{twice}");
    let early = PushMoment { since_contact: -0.1, ..good[0] };
    assert!(refused(vec![early]).contains("-0.1"));
    let nowhere = PushMoment { pusher_w: Vector2::new(f64::NAN, 0.0), ..good[0] };
    assert!(refused(vec![nowhere]).contains("NaN"));
}
