//! What each effect does to pushes that can be worked out by hand.

use effects::{Channels, EffectError, Object, PushPhysics, Rig, StepInput, Surface, Track, by_id};
use mechanics::predict_with_external_wrench;
use mechanics::{Ellipsoid, LimitSurface, MechanicsError, Patch, PointSet, Pusher, Slider};
use nalgebra::{Matrix4, Vector2, Vector4};
use planar::{Pose, Shape, Twist, Wrench};
use std::sync::Arc;

const SIDE: f64 = 0.09;
const MASS: f64 = 0.8;
const FRICTION: f64 = 0.25;
const SPEED: f64 = 0.02;
const RADIUS: f64 = 0.005;
const LOAD: f64 = FRICTION * MASS * 9.81;

fn rig(surface: Surface) -> Rig {
    Rig::new(surface, FRICTION, FRICTION).unwrap()
}

fn with(id: &str, values: &[f64]) -> PushPhysics {
    PushPhysics::new(rig(Surface::Ellipsoid)).with(by_id(id).unwrap(), values).unwrap()
}

fn predict(id: &str, values: &[f64], step: &StepInput) -> Channels {
    with(id, values).predict(step).unwrap()
}

/// A push of `way` along +x at the left edge of a square at the table's origin, `y` off its middle.
fn push(y: f64, way: f64) -> StepInput {
    push_along(y, Vector2::new(way, 0.0))
}

fn push_along(y: f64, way: Vector2<f64>) -> StepInput {
    let shape = Arc::new(Shape::square(SIDE).unwrap());
    let start = Vector2::new(-0.5 * SIDE - RADIUS, y);
    StepInput {
        object: Arc::new(Object::uniform(shape, MASS).unwrap()),
        pusher_radius: RADIUS,
        pose_wb: Pose::default(),
        twist_wb: Twist { linear: way.normalize() * SPEED, angular: 0.0 },
        track: Track::straight(start, start + way, way.norm() / SPEED),
        touching: true,
        since_contact: 1.0,
        run_up: None,
        progress: 0.5,
        session: 0,
    }
}

/// A step after the pusher stopped, with the object still going at `speed` along +x.
fn stopped(speed: f64, duration: f64) -> StepInput {
    let step = push(0.0, 1e-3);
    let start = step.track.start();
    let twist_wb = Twist::new(speed, 0.0, 0.0);
    StepInput { twist_wb, track: Track::straight(start, start, duration), touching: false, ..step }
}

#[track_caller]
fn near(value: f64, expected: f64, tolerance: f64) {
    assert!((value - expected).abs() <= tolerance, "{value}, expected {expected}");
}

#[test]
fn a_centered_push_needs_the_load_of_friction_and_nothing_else() {
    let channels = PushPhysics::new(rig(Surface::Ellipsoid)).predict(&push(0.0, 4e-3)).unwrap();
    near(channels.dx, 4e-3, 1e-12);
    near(channels.force_normal, LOAD, 1e-12);
    near(channels.dy.abs() + channels.dtheta.abs() + channels.force_tangential.abs(), 0.0, 1e-12);
}

#[test]
fn the_force_follows_the_friction_of_the_support_and_its_drift() {
    near(predict("support-friction", &[0.5], &push(0.0, 4e-3)).force_normal, 2.0 * LOAD, 1e-12);
    let last = StepInput { progress: 1.0, ..push(0.0, 4e-3) };
    near(predict("friction-drift", &[0.2], &last).force_normal, 1.1 * LOAD, 1e-12);
}

#[test]
fn a_wider_pressure_turns_less() {
    // ω = −y v/(c² + x² + y²) for a sticking push along x at (−x, y).
    let (y, way, c) =
        (0.004, 1e-5, 0.9 * SIDE * (2.0_f64.sqrt() + (1.0 + 2.0_f64.sqrt()).ln()) / 6.0);
    let expected = -y * way / (c * c + 0.25 * SIDE * SIDE + y * y);
    near(predict("pressure-radius", &[0.9], &push(y, way)).dtheta, expected, 1e-8);
}

#[test]
fn shape_one_is_the_exact_surface_and_shape_zero_the_ellipsoid() {
    let step = push(0.02, 4e-3);
    let patch = PushPhysics::new(rig(Surface::UniformPatch));
    assert_eq!(predict("limit-surface-shape", &[1.0], &step), patch.predict(&step).unwrap());
    let back = patch.clone().with(by_id("limit-surface-shape").unwrap(), &[0.0]).unwrap();
    let ellipsoid = PushPhysics::new(rig(Surface::Ellipsoid)).predict(&step).unwrap();
    near(back.predict(&step).unwrap().dtheta, ellipsoid.dtheta, 1e-11);
    assert!((patch.predict(&step).unwrap().dtheta - ellipsoid.dtheta).abs() > 1e-3);
}

#[test]
fn a_push_through_the_center_of_friction_does_not_turn() {
    let channels = predict("friction-center-offset", &[3e-3, 7e-3], &push(7e-3, 4e-3));
    near(channels.dtheta, 0.0, 1e-12);
    // ∫ y² dA/A of the square moves the center towards the rougher side.
    let y = SIDE * SIDE / 12.0 * 2.0;
    let channels = predict("friction-gradient", &[0.0, 2.0], &push(y, 1e-3));
    near(channels.dtheta, 0.0, 1e-8);
    let far = Vector2::new(0.3, 0.0);
    let step = push(0.0, 1e-5);
    let start = step.track.start() + far;
    let end = start + Vector2::new(1e-5, 0.0);
    let step = StepInput {
        pose_wb: Pose { position: far, angle: 0.0 },
        track: Track::straight(start, end, 1.0),
        ..step
    };
    let force = predict("friction-gradient", &[1.0, 0.0], &step).force_normal;
    near(force, LOAD * 0.3_f64.exp(), 1e-4);
}

#[test]
fn along_the_grain_friction_is_the_root_of_the_ratio_times_the_mean() {
    for id in ["table-anisotropy", "body-anisotropy"] {
        let step = push(0.0, 4e-3);
        near(predict(id, &[1.44, 0.0], &step).force_normal, 1.2 * LOAD, 1e-12);
        let across = std::f64::consts::FRAC_PI_2;
        near(predict(id, &[1.44, across], &step).force_normal, LOAD / 1.2, 1e-12);
        // The grain pulls a push that is oblique to it aside, across the grain.
        assert!(predict(id, &[1.44, 0.5], &step).dtheta.abs() > 1e-4, "{id}");
    }
}

#[test]
fn gravity_along_the_push_helps_it() {
    let channels = predict("table-tilt", &[0.4, 0.0], &push(0.0, 4e-3));
    near(channels.force_normal, LOAD - MASS * 0.4, 1e-10);
    near(channels.dx, 4e-3, 1e-10);
    let steep = with("table-tilt", &[2.0, -2.0]).predict(&push(0.0, 4e-3)).unwrap_err();
    assert!(steep.to_string().contains("slides without a push"), "{steep}");
}

#[test]
fn friction_of_a_translation_is_that_of_its_speed() {
    let step = push(0.0, 4e-3);
    let log = 1.0 + 0.1 * (1.0 + SPEED / 0.01_f64).ln();
    near(predict("rate-dependent-friction", &[0.1, 0.01], &step).force_normal, log * LOAD, 1e-9);
    let fading = 1.0 + 0.3 * (-(SPEED / 0.03_f64).powi(2)).exp();
    near(predict("support-stiction", &[1.3, 0.03], &step).force_normal, fading * LOAD, 1e-9);
}

#[test]
fn a_sliding_pusher_shows_the_friction_of_its_side() {
    let (left, right) = (Vector2::new(1e-3, 2e-3), Vector2::new(1e-3, -2e-3));
    let ratio = |id: &str, values: &[f64], way| {
        let channels = predict(id, values, &push_along(0.0, way));
        channels.force_tangential / channels.force_normal
    };
    near(ratio("pusher-friction", &[0.4], left), 0.4, 1e-12);
    near(ratio("pusher-friction-asymmetry", &[0.2], left), 0.3, 1e-12);
    near(ratio("pusher-friction-asymmetry", &[0.2], right), -0.2, 1e-12);
    near(ratio("pusher-stiction", &[1.5, 1e-4], left), 0.25, 1e-6);
    // Between the cones what is stuck sticks, at a ratio that neither cone would give.
    let between = ratio("pusher-stiction", &[3.0, 1e-4], Vector2::new(2e-3, 2e-3));
    assert!(between > 0.3 && between < 0.7, "{between}");
}

#[test]
fn between_the_cones_a_pusher_goes_on_as_it_was_measured() {
    let step = push_along(0.0, Vector2::new(2e-3, 2e-3));
    let ratio = |step: &StepInput| {
        let channels = predict("pusher-stiction", &[3.0, 1e-4], step);
        channels.force_tangential / channels.force_normal
    };
    // The object moves straight ahead: the pusher slips along its edge.
    let straight = Twist { linear: Vector2::new(step.twist_wb.linear.x, 0.0), angular: 0.0 };
    let slipping = StepInput { twist_wb: straight, ..step.clone() };
    near(ratio(&slipping), 0.25, 1e-12);
    assert!(ratio(&step) > 0.3);
    // Contact begins with a slip.
    near(ratio(&StepInput { touching: false, since_contact: 0.0, ..step }), 0.25, 1e-2);
}

#[test]
fn the_gap_shows_radius_offset_yaw_latency_and_compliance() {
    let (y, step) = (0.01, push(0.01, 1e-5));
    near(predict("pusher-radius", &[4e-4], &step).gap_start, 4e-4, 1e-15);
    near(predict("pose-offset", &[6e-4, 0.0], &step).gap_start, -6e-4, 1e-15);
    near(predict("pose-offset", &[0.0, 6e-4], &step).gap_start, 0.0, 1e-15);
    // The tip is told to be as much behind where it touches.
    near(predict("robot-offset", &[6e-4, 0.0], &step).gap_start, 6e-4, 1e-15);
    near(predict("robot-offset", &[0.0, 6e-4], &step).gap_start, 0.0, 1e-15);
    // An outline turned by ψ about its center has moved by −ψ y at the left edge.
    near(predict("yaw-offset", &[1e-3], &step).gap_start, 1e-3 * y, 1e-7);
    near(predict("stream-latency", &[5e-3], &step).gap_start, -5e-3 * SPEED, 1e-15);
    let channels = predict("pusher-compliance", &[1e-4], &push(0.0, 4e-3));
    near(channels.gap_end, -1e-4 * LOAD, 1e-12);
}

#[test]
fn at_first_contact_a_late_stream_and_a_soft_pusher_lose_way() {
    let first = StepInput { since_contact: 0.0, ..push(0.0, 4e-3) };
    near(predict("stream-latency", &[5e-3], &first).dx, 4e-3 - 5e-3 * SPEED, 1e-10);
    near(predict("pusher-compliance", &[1e-4], &first).dx, 4e-3 - 1e-4 * LOAD, 1e-10);
    near(predict("stream-latency", &[5e-3], &stopped(SPEED, 0.1)).dx, 5e-3 * SPEED, 1e-15);
}

#[test]
fn a_shifted_contact_makes_a_push_beside_the_middle_a_centered_one() {
    // Larger p is −y on the left edge, which runs from the upper to the lower corner.
    let channels = predict("contact-bias", &[6e-3], &push(6e-3, 4e-3));
    near(channels.dtheta, 0.0, 1e-12);
}

#[test]
fn a_round_corner_lies_inside_the_drawn_one() {
    let (radius, corner) = (2e-3, Vector2::new(-0.5 * SIDE, -0.5 * SIDE));
    let diagonal = Vector2::new(1.0, 1.0).normalize();
    let start = corner - RADIUS * diagonal;
    let track = Track::straight(start, start + 1e-6 * diagonal, 1.0);
    let step = StepInput { track, ..push(0.0, 1e-6) };
    let gap = predict("edge-rounding", &[radius], &step).gap_start;
    near(gap, -(2.0_f64.sqrt() - 1.0) * radius, 1e-12);
    near(predict("edge-rounding", &[radius], &push(0.02, 1e-3)).gap_start, 0.0, 1e-15);
}

#[test]
fn a_free_object_slides_on_until_friction_has_used_its_energy() {
    let speed: f64 = 0.2;
    let way = speed * speed / (2.0 * FRICTION * 9.81);
    let channels = predict("inertia", &[1.0], &stopped(speed, 0.5));
    near(channels.dx, way, 1e-3 * way);
    near(channels.gap_end, way, 1e-3 * way);
    assert_eq!(predict("inertia", &[0.0], &stopped(speed, 0.5)).dx, 0.0);
}

#[test]
fn acceleration_needs_its_force_and_a_slow_push_is_quasi_static() {
    let step = push(0.0, 4e-3);
    let (start, end) = (step.track.start(), step.track.end());
    let acceleration = Vector2::new(0.05, 0.0);
    let track = Track::accelerated(start, end, acceleration, 0.2);
    let twist_wb = Twist { linear: track.at(0.0).1, angular: 0.0 };
    let faster = StepInput { track, twist_wb, ..step };
    near(predict("inertia", &[1.0], &faster).force_normal, LOAD + MASS * 0.05, 1e-9);
    let turning = |id, values: &[f64]| {
        let step = push(0.015, 4e-3);
        let track = Track::straight(step.track.start(), step.track.end(), 400.0);
        predict(id, values, &StepInput { track, twist_wb: Twist::default(), ..step })
    };
    let (with, without) = (turning("inertia", &[1.0]), turning("inertia", &[0.0]));
    near(with.dtheta, without.dtheta, 1e-3 * without.dtheta.abs());
}

#[test]
fn the_sensor_turns_and_shifts_the_force() {
    let channels = predict("force-bias", &[0.3, -0.2, 0.1], &push(0.0, 4e-3));
    near(channels.force_normal, LOAD * 0.1_f64.cos() + 0.3, 1e-12);
    near(channels.force_tangential, LOAD * 0.1_f64.sin() - 0.2, 1e-12);
}

#[test]
fn a_tilt_pulls_like_the_same_load_of_the_mechanics() {
    let (shape, tilt) = (Shape::square(SIDE).unwrap(), Vector2::new(0.3, -0.4));
    let surface = Patch::uniform(&shape, LOAD).unwrap();
    let slider = Slider { shape: &shape, surface: &surface, pose_bs: Pose::default() };
    let pusher = Pusher { radius: RADIUS, friction: FRICTION };
    for (y, way) in [(0.01, (3e-3, 1e-3)), (-0.03, (3e-3, -2e-3)), (0.02, (1e-3, 2e-3))] {
        let step = push_along(y, Vector2::new(way.0, way.1));
        let velocity = step.track.mean_velocity();
        let push = slider.push_at(&pusher, &step.pose_wb, &contact_of(&step), &velocity);
        let load = Wrench { force: MASS * tilt, torque: 0.0 };
        let expected = predict_with_external_wrench(&surface, &push, &load).unwrap();
        let short = Track::straight(step.track.start(), step.track.start() + 1e-6 * velocity, 1e-6);
        let step = StepInput { track: short, ..step };
        let model = PushPhysics::new(rig(Surface::UniformPatch));
        let model = model.with(by_id("table-tilt").unwrap(), tilt.as_slice()).unwrap();
        let got = model.predict(&step).unwrap();
        near(1e6 * got.dtheta, expected.twist_ws_s.angular, 1e-4 * SPEED / SIDE);
        near(got.force_normal, expected.force_s.x, 1e-4 * LOAD);
        near(got.force_tangential, expected.force_s.y, 1e-4 * LOAD);
    }
}

fn contact_of(step: &StepInput) -> planar::Contact {
    let center = step.pose_wb.inverse_transform_point(&step.track.start());
    step.object.shape().contact(&center, step.pusher_radius)
}

/// A square whose mass is `lever` beside its middle, along y, and its step of a push at its left edge.
fn unbalanced(lever: f64) -> (Arc<Object>, StepInput) {
    let shape = Arc::new(Shape::square(SIDE).unwrap());
    let object = Object::new(shape, MASS, 1.1e-3, Vector2::new(0.0, lever)).unwrap();
    let object = Arc::new(object);
    (object.clone(), StepInput { object, ..push(0.0, 1e-3) })
}

/// The tilt along x, in m/s², at which an unbalanced square slides by itself on a surface.
fn largest_tilt(surface: &dyn LimitSurface, lever: f64) -> f64 {
    let load = Wrench::from_force_at(&Vector2::new(MASS, 0.0), &Vector2::new(0.0, lever));
    1.0 / surface.level(&load).unwrap()
}

#[test]
fn what_slides_by_itself_is_decided_on_the_surface_in_force() {
    // Tilts end at 2 m/s²: on a smooth table that is enough.
    let (square, friction) = (Shape::square(SIDE).unwrap(), 0.1);
    let load = friction * MASS * 9.81;
    let ellipsoid = Ellipsoid::uniform(&square, load).unwrap();
    let patch = Patch::uniform(&square, load).unwrap();
    let on = |surface| PushPhysics::new(Rig::new(surface, FRICTION, friction).unwrap());
    let tilted = |model: PushPhysics, tilt: f64, step: &StepInput| {
        let tilted = model.with(by_id("table-tilt").unwrap(), &[tilt, 0.0]).unwrap();
        tilted.predict(step)
    };
    let is_refused = |found: Result<Channels, EffectError>| match found {
        Ok(_) => false,
        Err(EffectError::Mechanics(MechanicsError::SlidesByItself { level })) => level >= 1.0,
        Err(error) => panic!("{error}"),
    };
    let (mut apart, touching) = (0.0_f64, [true, false]);
    for lever in [0.0, 0.015, 0.03, 0.04, -0.03] {
        let (_, step) = unbalanced(lever);
        let [on_ellipsoid, on_patch] =
            [largest_tilt(&ellipsoid, lever), largest_tilt(&patch, lever)];
        apart = apart.max((on_ellipsoid / on_patch - 1.0).abs());
        let own = PointSet::sampling(&square, load, 900).unwrap();
        let shape = by_id("limit-surface-shape").unwrap();
        let given = |surface: Arc<dyn LimitSurface>| on(Surface::Given(surface));
        let models = [
            (on(Surface::Ellipsoid), on_ellipsoid, 1e-6),
            (on(Surface::UniformPatch), on_patch, 1e-3),
            (on(Surface::Ellipsoid).with(shape, &[1.0]).unwrap(), on_patch, 1e-3),
            (given(Arc::new(patch.clone())), on_patch, 1e-6),
            (given(Arc::new(own.clone())), largest_tilt(&own, lever), 1e-6),
        ];
        for (model, limit, tolerance) in models {
            for touching in touching {
                // The pusher leaves, so that the object has to rest.
                let way = Vector2::new(-1e-3, 0.0);
                let start = step.track.start();
                let track = Track::straight(start, start + way, 0.05);
                let step = StepInput { touching, track, ..step.clone() };
                let at = |share: f64| tilted(model.clone(), share * limit, &step);
                assert!(!is_refused(at(1.0 - tolerance)), "{model:?} {lever} {limit}");
                assert!(is_refused(at(1.0 + tolerance)), "{model:?} {lever} {limit}");
            }
        }
    }
    // Between the two surfaces there are loads that only one of them holds.
    assert!(apart > 0.05, "{apart}");
}

#[test]
fn where_friction_comes_to_hold_an_object_no_more_the_pusher_may() {
    // On the way friction falls to a half of what it is at first, and below what holds the object.
    let (rate, tilt, way) = (-4.0, 1.8, 0.15);
    let step = push(0.0, way);
    let tilted = |tilt: f64| {
        let falling = with("friction-gradient", &[rate, 0.0]);
        falling.with(by_id("table-tilt").unwrap(), &[tilt, 0.0]).unwrap().predict(&step)
    };
    // Uphill it rests on the pusher, which bears its weight's share and its friction.
    let uphill = tilted(-tilt).unwrap();
    let mean = ((rate * way).exp() - 1.0) / (rate * way);
    near(uphill.force_normal, LOAD * mean + MASS * tilt, 2e-3 * LOAD);
    // Downhill it runs away.
    let message = tilted(tilt).unwrap_err().to_string();
    assert!(message.contains("slides without a push"), "{message}");
}

#[test]
fn stiction_holds_what_sliding_friction_would_not() {
    let start = push(0.0, 1e-3).track.start();
    let track = Track::straight(start, start - Vector2::new(1e-3, 0.0), 0.05);
    let rest = StepInput { track, ..push(0.0, 1e-3) };
    let smooth = with("support-friction", &[0.1]);
    let sticky = smooth.with(by_id("support-stiction").unwrap(), &[1.5, 0.005]).unwrap();
    let tilted = |share: f64, step: &StepInput| {
        let tilt = [share * 0.1 * 9.81, 0.0];
        sticky.clone().with(by_id("table-tilt").unwrap(), &tilt).unwrap().predict(step)
    };
    assert!(tilted(1.5 - 1e-6, &rest).is_ok());
    assert!(tilted(1.5 + 1e-6, &rest).unwrap_err().to_string().contains("slides without a push"));
    // Uphill it can be pushed at a speed at which friction has faded.
    let uphill = tilted(-1.2, &push(0.0, 4e-3)).unwrap();
    near(uphill.force_normal, (1.0 + 1.2) * 0.1 * MASS * 9.81, 1e-6);
}

/// A rig on a surface of the user's, in the frame of the outline.
fn given(surface: impl LimitSurface + 'static) -> PushPhysics {
    PushPhysics::new(rig(Surface::Given(Arc::new(surface))))
}

#[test]
fn a_given_surface_carries_effects_like_the_built_in_ones() {
    let shape = Shape::square(SIDE).unwrap();
    let pairs = [
        (Surface::Ellipsoid, given(Ellipsoid::uniform(&shape, LOAD).unwrap()), 1e-9),
        (Surface::UniformPatch, given(Patch::uniform(&shape, LOAD).unwrap()), 2e-4),
        (Surface::UniformPatch, given(PointSet::sampling(&shape, LOAD, 900).unwrap()), 2e-2),
    ];
    let effects: [(&str, &[f64]); 5] = [
        ("support-friction", &[0.3]),
        ("pressure-radius", &[0.92]),
        ("friction-center-offset", &[2e-3, -3e-3]),
        ("table-tilt", &[0.2, -0.1]),
        ("inertia", &[1.0]),
    ];
    for (surface, own, tolerance) in pairs {
        // Nothing tells where the load of a given surface is: it moves as it is.
        let is_rigid = matches!(surface, Surface::Ellipsoid);
        let leans = |id: &str| !is_rigid && id == "friction-center-offset";
        for (id, values) in effects.into_iter().filter(|(id, _)| !leans(id)) {
            let effect = by_id(id).unwrap();
            for y in [-0.03, 0.004, 0.02] {
                let step = push_along(y, Vector2::new(3e-3, 1e-3));
                let model = PushPhysics::new(rig(surface.clone()));
                let expected = model.with(effect, values).unwrap().predict(&step).unwrap();
                let got = own.clone().with(effect, values).unwrap().predict(&step).unwrap();
                let scale = 0.1 * tolerance;
                near(got.dtheta, expected.dtheta, scale);
                near(got.force_normal, expected.force_normal, 10.0 * scale);
            }
        }
    }
}

/// Points of a square whose pressure is (w + g·r + a r²), with a center asked for and the mean
/// distance from it that uniform pressure has from the middle.
fn leaning(center: Vector2<f64>) -> PointSet {
    const N: usize = 60;
    let place = |k: usize| SIDE * ((k as f64 + 0.5) / N as f64 - 0.5);
    let places: Vec<_> = (0..N * N).map(|k| Vector2::new(place(k % N), place(k / N))).collect();
    let mut matrix = Matrix4::zeros();
    let mut uniform = 0.0;
    let terms =
        |r: &Vector2<f64>| Vector4::new(1.0, r.x / SIDE, r.y / SIDE, r.dot(r) / SIDE / SIDE);
    for r in &places {
        let held = Vector4::new(1.0, r.x, r.y, (r - center).norm());
        matrix += held * terms(r).transpose() / places.len() as f64;
        uniform += r.norm() / places.len() as f64;
    }
    let goal = Vector4::new(1.0, center.x, center.y, uniform);
    let law = matrix.lu().solve(&goal).unwrap();
    let share = |r: &Vector2<f64>| LOAD / places.len() as f64 * law.dot(&terms(r));
    PointSet::new(places.iter().map(|r| (*r, share(r)))).unwrap()
}

/// Another pressure with the same center and mean distance moves the object nearly alike; one that
/// is shifted as it is does not.
#[test]
fn on_the_patch_the_load_leans_under_the_outline() {
    let center = Vector2::new(5e-3, -3e-3);
    let effect = by_id("friction-center-offset").unwrap();
    let with = |model: PushPhysics| model.with(effect, &[center.x, center.y]).unwrap();
    let leaning = given(leaning(center));
    let model = with(PushPhysics::new(rig(Surface::UniformPatch)));
    let rigid = with(given(Patch::uniform(&Shape::square(SIDE).unwrap(), LOAD).unwrap()));
    let off = |model: &PushPhysics| {
        let miss = |y: f64| {
            let step = push_along(y, Vector2::new(3e-3, 1e-3));
            let turn = |model: &PushPhysics| model.predict(&step).unwrap().dtheta;
            (turn(model) / turn(&leaning) - 1.0).abs()
        };
        [-0.035, -0.02, 0.01, 0.03].map(miss).into_iter().fold(0.0, f64::max)
    };
    // 0.6 % against 2.6 %.
    assert!(off(&model) < 0.01 && off(&rigid) > 0.02, "{} {}", off(&model), off(&rigid));
}
