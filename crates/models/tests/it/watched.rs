//! Pushes that are watched: what they have drawn is learnt from their beginning.

use effects::Spread;
use filter::{PlanarSummary, Rule, Simplex};
use models::{
    Description, ModelError, PoseSeen, PushModel, PushTracker, RecordedPush, RollOut, Setup, Wander,
};
use planar::Pose;

use super::per_push::{TABLE, description, drawing_pushes};

/// How far centers of friction differ along y from push to push, in m.
const SD: f64 = 0.006;
const STEADY: Wander = Wander { length: 1e3, scatter: [1e-4, 3e-3] };
const SEEN_SD: [f64; 2] = [2e-5, 5e-4];

fn varied(sd: f64) -> Description {
    let spreads = [("dy", Spread::Sd(sd))];
    description(&[("friction-center-offset", &[0.0, 0.0], &spreads)], 0.0)
}

/// Where a push ends, as foreseen after some steps with what was learnt, and without; and the tracker.
fn watched(
    model: &dyn PushModel,
    push: &RecordedPush,
    n_seen: usize,
    (wander, rule): (Wander, &dyn Rule),
) -> ([PlanarSummary; 2], [f64; 2]) {
    let settings = push.watched_settings();
    let roll_out = RollOut { model, pushed: &push.pushed, settings: &settings };
    let start = &push.poses_wb[0];
    let mut tracker = PushTracker::start(roll_out, start, &push.path, wander, rule).unwrap();
    let steps = push.path.steps(settings.step).unwrap();
    let seen = |k: usize| PoseSeen { pose_wb: push.poses_wb[k], sd: SEEN_SD };
    for (k, step) in steps.iter().enumerate().take(n_seen) {
        tracker.predict(step).unwrap();
        tracker.update(&seen(k + 1)).unwrap();
    }
    let without = tracker.forgetful(&seen(n_seen)).unwrap();
    let ends = [&tracker, &without].map(|one| one.ahead(&steps[n_seen..]).unwrap());
    let state = tracker.state();
    (ends, [state.mean()[3], state.covariance()[(3, 3)].sqrt()])
}

#[test]
fn the_beginning_of_a_push_tells_where_its_center_of_friction_is_and_where_it_ends() {
    let model = varied(SD).build_in(TABLE, &[]).unwrap();
    let (mut with, mut without) = (0.0, 0.0);
    let pushes = drawing_pushes(SD, 16);
    let places: Vec<f64> = (0..16).map(|k| f64::from(k * 37 % 16)).collect();
    let (mut order, mut learnt) = (Vec::new(), Vec::new());
    for (push, place) in pushes.iter().zip(places) {
        let (ends, [number, sd]) = watched(model.as_ref(), push, 3, (STEADY, &Simplex));
        let end = push.poses_wb[push.poses_wb.len() - 1];
        let [own, other] = ends.map(|said| (said.mean.z - end.angle).powi(2));
        (with, without) = (with + own, without + other);
        assert!(sd < 0.35, "{}: {sd}", push.name);
        assert!(ends[0].covariance[(2, 2)] < 0.5 * ends[1].covariance[(2, 2)], "{ends:?}");
        order.push(place);
        learnt.push(number);
    }
    assert!(with < 0.1 * without, "{with} {without}");
    // The centers of the pushes are in the order of their places.
    let mean = learnt.iter().sum::<f64>() / 16.0;
    let product = |(place, number): (&f64, &f64)| (place - 7.5) * (number - mean);
    let product: f64 = order.iter().zip(&learnt).map(product).sum();
    let square = |values: &[f64], mean: f64| -> f64 {
        values.iter().map(|value| (value - mean).powi(2)).sum()
    };
    let correlation = product / (square(&order, 7.5) * square(&learnt, mean)).sqrt();
    assert!(correlation > 0.9, "{correlation} {learnt:?}");
}

#[test]
fn what_wanders_fast_is_forgotten() {
    let model = varied(SD).build_in(TABLE, &[]).unwrap();
    let push = &drawing_pushes(SD, 16)[0];
    let restless = Wander { length: 1e-4, ..STEADY };
    let (_, [number, sd]) = watched(model.as_ref(), push, 3, (restless, &Simplex));
    let (_, [steady, _]) = watched(model.as_ref(), push, 3, (STEADY, &Simplex));
    assert!(number.abs() < steady.abs() && sd > 0.5, "{number} ± {sd}, {steady}");
}

#[test]
fn recorded_pushes_tell_how_widely_they_differ() {
    let setup = Setup { support: TABLE, own: Vec::new() };
    let pushes = drawing_pushes(SD, 16);
    // The model thinks that they differ a third as much.
    let found = varied(SD / 3.0).watched(&setup, &pushes, 0.333).unwrap();
    assert_eq!(found.n_pushes, 16);
    assert!((1.9..5.0).contains(&found.widened), "{found:?}");
    assert!(found.wander.length > 0.2, "what a push has drawn stays: {found:?}");
    // Nine in ten of seventeen ends are sixteen: all of these.
    let model = varied(SD / 3.0).with(&found.calibration()).unwrap().build_in(TABLE, &[]).unwrap();
    let mut held = [0; 2];
    for push in &pushes {
        let end = push.poses_wb[push.poses_wb.len() - 1];
        let measured = [end.position.x, end.position.y, end.angle];
        let ends = push.foreseen(model.as_ref(), found.wander, 0.333).unwrap();
        for (k, mut said) in ends.into_iter().enumerate() {
            said.covariance *= found.scale[k];
            // The end was measured to a micrometer.
            held[k] += usize::from(said.gaussian_level(measured, [1e-6, 1e-5]) < 0.9 + 1e-3);
        }
    }
    assert!(held == [16; 2], "{held:?} {found:?}");
    // Of the pushes themselves every level is there once.
    let mut levels: Vec<[f64; 2]> = Vec::new();
    for push in &pushes {
        let ends = push.foreseen(model.as_ref(), found.wander, 0.333).unwrap();
        levels.push(found.levels(push, &ends));
    }
    for k in 0..2 {
        levels.sort_by(|a, b| a[k].total_cmp(&b[k]));
        let is_it = |(place, level): (usize, &[f64; 2])| level[k] == place as f64 / 17.0;
        assert!(levels.iter().enumerate().all(is_it), "{levels:?}");
    }
    let few = varied(SD).watched(&setup, &pushes[..7], 0.333).unwrap_err();
    assert!(matches!(few, ModelError::TooFewPushes { n_pushes: 7, .. }), "{few}");
}

#[test]
fn what_cannot_be_watched_is_refused() {
    let model = varied(SD).build_in(TABLE, &[]).unwrap();
    let push = &drawing_pushes(SD, 16)[0];
    let settings = push.watched_settings();
    let roll_out = RollOut { model: model.as_ref(), pushed: &push.pushed, settings: &settings };
    let start = |wander, pose_wb: Pose| {
        PushTracker::start(roll_out, &pose_wb, &push.path, wander, &Simplex).map(|_| ())
    };
    let here = push.poses_wb[0];
    for wander in [
        Wander { length: 0.0, ..STEADY },
        Wander { scatter: [-1.0, 0.0], ..STEADY },
        Wander { scatter: [0.0, f64::NAN], ..STEADY },
    ] {
        let error = start(wander, here).unwrap_err();
        assert!(matches!(error, ModelError::InvalidValue { .. }), "{error}");
    }
    assert!(start(STEADY, Pose::new(f64::NAN, 0.0, 0.0)).is_err());
    let mut tracker = PushTracker::start(roll_out, &here, &push.path, STEADY, &Simplex).unwrap();
    let before = tracker.state().clone();
    let lost = PoseSeen { pose_wb: Pose::new(f64::NAN, 0.0, 0.0), sd: SEEN_SD };
    assert!(tracker.update(&lost).is_err());
    assert_eq!(*tracker.state(), before);
    assert!(tracker.forgetful(&PoseSeen { pose_wb: here, sd: [-1.0, 0.0] }).is_err());
}
