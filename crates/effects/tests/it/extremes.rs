//! Extreme but legal input: every effect, at both ends of its range and at its typical size, predicts
//! finite numbers or refuses with a reason.

use effects::all;
use effects::{Effect, EffectError, Object, PushPhysics, Rig, StepInput, Surface, Track};
use nalgebra::Vector2;
use planar::{Polygon, Pose, Shape, Twist, mit_object};
use proptest::prelude::{Just, ProptestConfig, Strategy, prop_oneof, proptest};
use std::f64::consts::FRAC_PI_2;
use std::sync::{Arc, OnceLock};

fn polygon(corners: &[(f64, f64)]) -> Shape {
    let corners = corners.iter().map(|(x, y)| 1e-3 * Vector2::new(*x, *y)).collect();
    Shape::Polygon(Polygon::new(corners).unwrap())
}

/// Known outlines, and ones that are not convex or very long.
fn shapes() -> Vec<Shape> {
    let l = [(0., 0.), (80., 0.), (80., 30.), (30., 30.), (30., 90.), (0., 90.)];
    let u = [
        (-50., 0.),
        (50., 0.),
        (50., 85.),
        (25., 85.),
        (25., 30.),
        (-20., 30.),
        (-20., 80.),
        (-50., 80.),
    ];
    let bow = [(0., 0.), (40., 14.), (80., 0.), (80., 40.), (40., 26.), (0., 40.)];
    let known = ["rect1", "tri2", "butter", "ellip2"].map(|name| mit_object(name).unwrap().shape);
    let own = [polygon(&l), polygon(&u), polygon(&bow), Shape::rectangle(0.15, 0.015).unwrap()];
    known.into_iter().chain(own).collect()
}

/// The tables of their limit surfaces are made once.
fn objects() -> &'static [Arc<Object>] {
    static OBJECTS: OnceLock<Vec<Arc<Object>>> = OnceLock::new();
    OBJECTS.get_or_init(|| {
        let object = |shape| Arc::new(Object::uniform(Arc::new(shape), 0.8).unwrap());
        shapes().into_iter().map(object).collect()
    })
}

/// Low, high, and typical values of all parameters.
fn values(effect: &dyn Effect, rig: &Rig, step: &StepInput) -> [Vec<f64>; 3] {
    let about = effect.info();
    let ranges = || (0..about.parameters.len()).map(|k| effect.range_in(k, step));
    let (low, high) = (ranges().map(|range| range.0), ranges().map(|range| range.1));
    [low.collect(), high.collect(), about.typical(rig)]
}

/// Predicts with every effect.
fn check(rig: &Rig, step: &StepInput) {
    for effect in all() {
        for values in values(effect.as_ref(), rig, step) {
            let physics = PushPhysics::new(rig.clone()).with(effect, &values).unwrap();
            match physics.predict(step) {
                Ok(found) => {
                    let is_finite = found.to_array().iter().all(|value| value.is_finite());
                    assert!(is_finite, "{} {values:?} {step:?} {found:?}", effect.info().id);
                }
                Err(error) => assert!(!error.to_string().is_empty()),
            }
        }
    }
}

fn step(object: &Arc<Object>, edge: usize, p: f64, radius: f64, beta: f64, way: f64) -> StepInput {
    let shape = object.shape();
    let pose_wb = Pose::new(0.3, -0.1, 0.7);
    let normal = shape.inward_normal_at(edge, p);
    let start = pose_wb.transform_point(&(shape.point_at(edge, p) - radius * normal));
    let direction = pose_wb.rotate(&Pose::new(0.0, 0.0, beta).rotate(&normal));
    StepInput {
        object: object.clone(),
        pusher_radius: radius,
        pose_wb,
        twist_wb: Twist::default(),
        track: Track::straight(start, start + way * direction, 0.2),
        touching: true,
        since_contact: 1.0,
        run_up: None,
        progress: 0.5,
        session: 0,
    }
}

#[test]
fn every_effect_predicts_on_every_outline() {
    for surface in [Surface::Ellipsoid, Surface::UniformPatch] {
        let rig = Rig::new(surface, 0.25, 0.25).unwrap();
        for object in objects() {
            for edge in 0..object.shape().n_edges().min(2) {
                let step = step(object, edge, 0.4, 0.005, 0.2, 4e-3);
                for effect in all() {
                    let typical = effect.info().typical(&rig);
                    let physics = PushPhysics::new(rig.clone()).with(effect, &typical).unwrap();
                    let found = physics.predict(&step);
                    let name = (effect.info().id, edge, object.shape().bounding_radius());
                    let found = found.unwrap_or_else(|error| panic!("{name:?}: {error}"));
                    assert!((1e-3..1e-2).contains(&found.dx.hypot(found.dy)), "{name:?} {found:?}");
                }
            }
        }
    }
}

/// A mean speed from nothing to fast, mostly extreme.
fn speed() -> impl Strategy<Value = f64> {
    prop_oneof![
        Just(0.0),
        Just(1e-165),
        Just(5e-324),
        (-320.0..-5.0f64).prop_map(|exponent| 10_f64.powf(exponent)),
        (-5.0..1.0f64).prop_map(|exponent| 10_f64.powf(exponent)),
        (6.0..308.0f64).prop_map(|exponent| 10_f64.powf(exponent)),
    ]
}

fn angle() -> impl Strategy<Value = f64> {
    prop_oneof![Just(FRAC_PI_2), Just(-FRAC_PI_2), Just(0.0), -3.2..3.2f64]
}

/// How long a step takes, in s.
fn duration() -> impl Strategy<Value = f64> {
    prop_oneof![
        Just(0.2),
        Just(5e-324),
        Just(1e300),
        (-9.0..9.0f64).prop_map(|exponent| 10_f64.powf(exponent)),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn extreme_steps_are_finite_or_refused(
        object in 0..8usize, edge in 0..6usize, p in 0.0..1.0f64, beta in angle(),
        way in prop_oneof![Just(0.0), Just(4e-3), -1e-3..0.03f64],
        radius in prop_oneof![Just(0.0), Just(0.005), Just(1e-200), Just(1e3)],
        duration in duration(),
        ends in (speed(), speed()),
        twist in (speed(), angle()),
        friction in prop_oneof![Just(0.0), Just(0.25), Just(1e-300), Just(10.0)],
        since in prop_oneof![Just(0.0), Just(1.0), Just(1e300)],
        touching in 0..2u8,
        is_exact in 0..2u8,
    ) {
        let plain = step(&objects()[object], edge, p, radius, beta, way);
        let (start, end) = (plain.track.start(), plain.track.end());
        let direction = Vector2::new((0.7 + beta).cos(), (0.7 + beta).sin());
        let track = match edge % 3 {
            0 => Track::straight(start, end, duration),
            _ => Track::cubic((start, ends.0 * direction), (end, ends.1 * direction), duration),
        };
        let linear = twist.0 * Vector2::new(twist.1.cos(), twist.1.sin());
        let step = StepInput {
            track,
            twist_wb: Twist { linear, angular: twist.1 * ends.0 },
            since_contact: since,
            run_up: None,
            touching: touching == 1,
            progress: p,
            ..plain
        };
        let surface = if is_exact == 1 { Surface::UniformPatch } else { Surface::Ellipsoid };
        check(&Rig::new(surface, friction, 0.25).unwrap(), &step);
    }

    #[test]
    fn extreme_objects_and_rigs_are_finite_or_refused(
        size in -320.0..300.0f64, mass in -320.0..308.0f64, moment in -320.0..308.0f64,
        friction in -300.0..300.0f64, gravity in -300.0..300.0f64, place in -10.0..308.0f64,
        progress in prop_oneof![Just(0.5), Just(-40.0), Just(1e308)],
        substep in -320.0..3.0f64,
    ) {
        let ten = |exponent: f64| 10_f64.powf(exponent);
        let (half, center) = (0.05, Vector2::new(0.01, 0.0));
        let shape = if size < -280.0 { Ok(Shape::square(0.1).unwrap()) } else { Shape::square(ten(size)) };
        let Ok(shape) = shape else { return Ok(()) };
        let object = Object::new(Arc::new(shape), ten(mass), ten(moment), center);
        let rig = Rig::new(Surface::Ellipsoid, 0.25, ten(friction));
        let rig = rig.and_then(|rig| rig.with_gravity(ten(gravity)));
        let rig = rig.and_then(|rig| rig.with_longest_substep(ten(substep)));
        let (Ok(object), Ok(rig)) = (object, rig) else { return Ok(()) };
        let mut step = step(&Arc::new(object), 1, 0.3, half, 0.1, 4e-3);
        step.progress = progress;
        check(&rig, &step);
        step.pose_wb.position.x += ten(place);
        check(&rig, &step);
    }
}

#[test]
fn a_slow_push_moves_as_far_as_a_fast_one() {
    // 4 mm in 10³⁰³ s are 4·10⁻³⁰⁶ m/s, of which no square can be formed.
    for surface in [Surface::Ellipsoid, Surface::UniformPatch] {
        let physics = PushPhysics::new(Rig::new(surface, 0.25, 0.25).unwrap());
        let fast = step(&objects()[0], 1, 0.3, 0.005, 0.0, 4e-3);
        let (start, end) = (fast.track.start(), fast.track.end());
        let slow = StepInput { track: Track::straight(start, end, 1e303), ..fast.clone() };
        let (slow, fast) = (physics.predict(&slow).unwrap(), physics.predict(&fast).unwrap());
        assert!((slow.dx - fast.dx).abs() < 1e-9 && (slow.dtheta - fast.dtheta).abs() < 1e-8);
        assert!((slow.force_normal - fast.force_normal).abs() < 1e-6, "{slow:?} {fast:?}");
    }
}

#[test]
fn friction_that_no_table_has_is_refused_with_its_size() {
    let physics = PushPhysics::new(Rig::new(Surface::Ellipsoid, 0.25, 0.25).unwrap());
    let with =
        |id, values: &[f64]| physics.clone().with(effects::by_id(id).unwrap(), values).unwrap();
    let plain = step(&objects()[0], 1, 0.3, 0.005, 0.0, 4e-3);
    let late = StepInput { progress: -40.0, ..plain.clone() };
    let error = with("friction-drift", &[0.15]).predict(&late).unwrap_err();
    let is_named = |error: &EffectError| matches!(error, EffectError::InvalidValue { name, unit: "N", .. } if name.contains("friction"));
    assert!(is_named(&error), "{error}");
    let shift = Vector2::new(1e4, 0.0);
    let (start, end) = (plain.track.start() + shift, plain.track.end() + shift);
    let mut far = StepInput { track: Track::straight(start, end, 0.2), ..plain };
    far.pose_wb.position += shift;
    let error = with("friction-gradient", &[1.0, 0.0]).predict(&far).unwrap_err();
    assert!(is_named(&error), "{error}");
}
