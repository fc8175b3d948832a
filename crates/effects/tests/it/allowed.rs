//! What the object and the pusher of a step allow of an effect.

use std::sync::Arc;

use effects::{
    EffectError, Object, PushPhysics, Rig, Spread, StepInput, Surface, Track, all, by_id,
};
use nalgebra::Vector2;
use planar::{Ellipse, Pose, Shape, Twist};

fn rig() -> Rig {
    Rig::new(Surface::Ellipsoid, 0.25, 0.25).unwrap()
}

/// A push of 4 mm at the left of an object, 10 mm off its middle.
fn push(shape: Shape, pusher_radius: f64) -> StepInput {
    let mut start = Vector2::new(-0.3, 0.01);
    for _ in 0..60 {
        start.x += shape.contact(&start, pusher_radius).gap;
    }
    StepInput {
        object: Arc::new(Object::uniform(Arc::new(shape), 0.8).unwrap()),
        pusher_radius,
        pose_wb: Pose::default(),
        twist_wb: Twist::default(),
        track: Track::straight(start, start + 4e-3 * Vector2::x(), 0.2),
        touching: true,
        since_contact: 1.0,
        run_up: None,
        progress: 0.5,
        session: 0,
    }
}

fn square(pusher_radius: f64) -> StepInput {
    push(Shape::square(0.09).unwrap(), pusher_radius)
}

fn predicted(id: &str, value: f64, step: &StepInput) -> Result<f64, EffectError> {
    let physics = PushPhysics::new(rig()).with(by_id(id).unwrap(), &[value]).unwrap();
    physics.predict(step).map(|found| found.dtheta)
}

#[test]
fn a_pressure_radius_is_as_large_as_the_object_allows() {
    // Objects that were measured: nearly all weight in the middle, and nearly all at the corners.
    let turns =
        [0.372, 1.0, 1.734].map(|ratio| predicted("pressure-radius", ratio, &square(0.005)));
    let [small, nominal, large] = turns.map(|turn| turn.unwrap().abs());
    assert!(small > nominal && nominal > large, "{small} {nominal} {large}");
    // All weight at the corners of a square, and at the rim of a disc: 3/2 of the mean distance.
    let disc = push(Shape::Ellipse(Ellipse::new(0.05, 0.05).unwrap()), 0.005);
    for (step, most) in [(square(0.005), 1.848_172), (disc, 1.5)] {
        assert!(predicted("pressure-radius", 0.9999 * most, &step).is_ok());
        let error = predicted("pressure-radius", 1.0001 * most, &step).unwrap_err();
        let EffectError::OutOfRange { high, .. } = &error else { panic!("{error}") };
        assert!((high / most - 1.0).abs() < 1e-5, "{high} {most}");
        assert!(error.to_string().contains("pressure-radius: ratio must be within 0.01 and 1."));
    }
}

#[test]
fn a_point_pushes_with_every_effect_and_an_outline_may_be_smaller() {
    let step = square(0.0);
    for surface in [Surface::Ellipsoid, Surface::UniformPatch] {
        let rig = Rig::new(surface, 0.25, 0.25).unwrap();
        for effect in all() {
            let values = effect.info().typical(&rig);
            let physics = PushPhysics::new(rig.clone()).with(effect, &values).unwrap();
            let found = physics.predict(&step).unwrap().to_array();
            assert!(found.iter().all(|value| value.is_finite()), "{}", effect.info().id);
        }
    }
    for excess in [1e-3, -1e-3] {
        assert!(predicted("pusher-radius", excess, &step).is_ok());
    }
    let excess = by_id("pusher-radius").unwrap();
    let error = PushPhysics::new(rig()).with(excess, &[-6e-3]).unwrap_err();
    assert!(matches!(error, EffectError::OutOfRange { low: -5e-3, .. }), "{error}");
}

#[test]
fn draws_and_coordinates_stay_within_what_a_step_allows() {
    let step = square(0.0);
    for (id, value, sd) in [("pusher-radius", 0.0, 4e-3), ("pressure-radius", 1.8, 0.2)] {
        let effect = by_id(id).unwrap();
        let name = effect.info().parameters[0].name;
        let physics = PushPhysics::new(rig()).with(effect, &[value]).unwrap();
        let physics = physics.with_spread(id, name, Spread::Sd(sd)).unwrap();
        assert_eq!(physics.predict_over_pushes(&step).unwrap().deviations.len(), 5);
        let (low, high) = effect.range_in(0, &step);
        for number in [-8.0, -1.0, 1.0, 8.0] {
            let drawn = physics.drawn(&[number], &step).settings()[0].parameters[name];
            assert!((low..=high).contains(&drawn), "{id} {drawn}");
        }
        let coordinate = effect.coordinates_in(&rig(), &step)[0];
        assert_eq!(coordinate.range, (low, high), "{id}");
    }
}

#[test]
fn spreads_of_pushes_and_places_are_in_one_unit() {
    let physics = || {
        let physics = PushPhysics::new(Rig::new(Surface::Ellipsoid, 0.25, 0.25).unwrap());
        physics.with(by_id("pusher-friction").unwrap(), &[0.25]).unwrap()
    };
    let (id, name) = ("pusher-friction", "friction");
    let one = physics().with_spread(id, name, Spread::Sd(0.05)).unwrap();
    assert!(one.clone().with_spread_of_places(id, name, Spread::Sd(0.1)).is_ok());
    let refused = one.with_spread_of_places(id, name, Spread::RelativeSd(0.1)).unwrap_err();
    let other = physics().with_spread_of_places(id, name, Spread::RelativeSd(0.1)).unwrap();
    assert_eq!(other.with_spread(id, name, Spread::Sd(0.05)).unwrap_err(), refused);
    assert!(matches!(refused, EffectError::TwoSpreads { .. }), "{refused}");
}

#[test]
fn parts_are_together_what_is_expected_and_no_others_are_asked_for() {
    let step = &square(0.005);
    let (id, names) = ("friction-center-offset", ["dx", "dy"]);
    let mut physics = PushPhysics::new(rig()).with(by_id(id).unwrap(), &[0.001, 0.002]).unwrap();
    for n in 1..=2 {
        physics = physics.with_spread(id, names[n - 1], Spread::Sd(0.004)).unwrap();
        let expected = physics.predict(step).unwrap().to_array();
        let all = physics.predict_parts(step, |_| true).unwrap();
        assert_eq!(all.added.len(), n);
        for (sum, expected) in all.sum().into_iter().zip(expected) {
            assert!((sum - expected).abs() < 1e-12, "{sum} {expected}");
        }
        let none = physics.predict_parts(step, |_| false).unwrap();
        assert_eq!(
            none.sum(),
            physics.of_typical_push().unwrap().predict(step).unwrap().to_array()
        );
        assert_ne!(none.sum(), all.sum());
        let one = physics.predict_parts(step, |parameter| parameter == n - 1).unwrap();
        assert_eq!(one.added[n - 1], all.added[n - 1]);
        assert!(one.added[..n - 1].iter().all(|added| *added == [0.0; 7]));
    }
}

/// A push of 4 mm at 20 mm/s at the left of a square, turned by `angle`, with the object moving with `twist_wb`.
fn oblique(angle: f64, twist_wb: Twist) -> StepInput {
    let start = square(0.005);
    let (from, _) = start.track.at(0.0);
    let way = 4e-3 * Vector2::new(angle.cos(), angle.sin());
    StepInput { track: Track::straight(from, from + way, 0.2), twist_wb, ..start }
}

#[test]
fn a_tip_that_sticks_harder_does_what_it_did_and_never_slides_where_friction_falls_too_fast() {
    let coulomb = |friction: f64, step: &StepInput| {
        let physics = PushPhysics::new(Rig::new(Surface::UniformPatch, friction, 0.25).unwrap());
        let found = physics.predict(step).unwrap();
        (found, found.force_tangential / found.force_normal)
    };
    let (mut n, mut n_fast) = (0, 0);
    for angle in (-60..60).map(|k| 0.02 * f64::from(k)) {
        let rest = oblique(angle, Twist::default());
        let ((held, _), (sliding, _)) = (coulomb(0.375, &rest), coulomb(0.25, &rest));
        let never = coulomb(5.0, &rest).0;
        if (never.dy - held.dy).abs() > 1e-9 || (never.dy - sliding.dy).abs() < 2e-5 {
            continue;
        }
        n += 1;
        // As both have it by the end, the object moves already.
        let twist = |found: &effects::Channels| {
            let [along, across] = [found.dx, found.dy].map(|way| way / 0.2);
            let (sin, cos) = angle.sin_cos();
            let linear = Vector2::new(cos * along - sin * across, sin * along + cos * across);
            Twist { linear, angular: found.dtheta / 0.2 }
        };
        for speed in [1e-4, 1e-3] {
            let rig = Rig::new(Surface::UniformPatch, 0.25, 0.25).unwrap();
            let stiction = by_id("pusher-stiction").unwrap();
            let physics = PushPhysics::new(rig).with(stiction, &[1.5, speed]).unwrap();
            let stuck = physics.predict(&oblique(angle, twist(&held))).unwrap();
            assert!((stuck.dy - held.dy).abs() < 1e-9, "{angle} {speed}: {stuck:?} {held:?}");
            let moving = physics.predict(&oblique(angle, twist(&sliding))).unwrap();
            let friction = (moving.force_tangential / moving.force_normal).abs();
            // It slides as fast as it may, or is held: not between, where a little more slip means less friction.
            let is_fast = (moving.dy - held.dy).abs() > 0.5 * (sliding.dy - held.dy).abs();
            let is_stuck = (moving.dy - held.dy).abs() < 1e-9;
            assert!(is_fast || is_stuck, "{angle} {speed}: {friction} {moving:?}");
            assert!(speed > 1e-4 || is_stuck || friction < 0.26, "{angle}: {friction}");
            n_fast += usize::from(is_fast);
        }
    }
    assert!(n >= 3 && n_fast >= n, "{n} {n_fast}");
}
