//! A pusher that leaves moves nothing, and one that turns back leaves the object where it was.

use effects::all;
use effects::{Channels, Object, PushPhysics, Rig, StepInput, Surface, Track, by_id};
use mechanics::Polyline;
use nalgebra::Vector2;
use planar::{MIT_NAMES, Polygon, Pose, Shape, Twist, mit_object};
use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

const RADIUS: f64 = 0.005;
const SPEED: f64 = 0.02;
const POSE: Pose = Pose { position: Vector2::new(0.3, -0.1), angle: 0.7 };

fn polygon(corners: &[(f64, f64)]) -> Shape {
    let corners = corners.iter().map(|(x, y)| 1e-3 * Vector2::new(*x, *y)).collect();
    Shape::Polygon(Polygon::new(corners).unwrap())
}

fn shapes() -> Vec<(String, Shape)> {
    let known = MIT_NAMES.iter().map(|name| (String::from(*name), mit_object(name).unwrap().shape));
    let own = [
        ("L", polygon(&[(0., 0.), (80., 0.), (80., 30.), (30., 30.), (30., 90.), (0., 90.)])),
        (
            "U",
            polygon(&[
                (-50., -40.),
                (50., -40.),
                (50., 45.),
                (25., 45.),
                (25., -10.),
                (-20., -10.),
                (-20., 40.),
                (-50., 40.),
            ]),
        ),
        ("10:1", Shape::rectangle(0.15, 0.015).unwrap()),
    ];
    known.chain(own.map(|(name, shape)| (name.to_owned(), shape))).collect()
}

/// Centers of a pusher that touches, frame of the outline: along edges and around convex vertices.
fn touching(shape: &Shape) -> Vec<Vector2<f64>> {
    let n = shape.n_edges();
    let mut centers = Vec::new();
    for edge in 0..n {
        let normal = |edge: usize, p: f64| shape.inward_normal_at(edge, p);
        for p in [0.03, 0.5, 0.97] {
            centers.push(shape.point_at(edge, p) - RADIUS * normal(edge, p));
        }
        let (before, after) = (normal(edge, 1.0), normal(edge + 1, 0.0));
        for share in [0.0, 0.3, 0.9] {
            let between = before.lerp(&after, share).normalize();
            centers.push(shape.point_at(edge, 1.0) - RADIUS * between);
        }
    }
    // In a notch the pusher may reach into the other wall.
    centers.retain(|center| shape.contact(center, RADIUS).gap.abs() < 1e-12);
    centers
}

/// A pusher that leaves from `center` at the angle `beta` from the contact's normal; none if its way
/// leads into another part of the outline.
fn leaving(object: &Arc<Object>, center: &Vector2<f64>, beta: f64) -> Option<StepInput> {
    let shape = object.shape();
    let normal = shape.contact(center, RADIUS).normal;
    let way = Pose::new(0.0, 0.0, beta).rotate(&(3e-3 * normal));
    let is_free = |k: u32| shape.contact(&(center + f64::from(k) / 20.0 * way), RADIUS).gap > -1e-9;
    let (start, end) = (POSE.transform_point(center), POSE.transform_point(&(center + way)));
    (0..=20).all(is_free).then(|| StepInput {
        object: object.clone(),
        pusher_radius: RADIUS,
        pose_wb: POSE,
        twist_wb: Twist::default(),
        track: Track::straight(start, end, way.norm() / SPEED),
        touching: true,
        since_contact: 1.0,
        run_up: None,
        progress: 0.5,
        session: 0,
    })
}

const BETAS: [f64; 9] = [FRAC_PI_2 + 1e-6, -FRAC_PI_2 - 1e-6, 1.7, -1.7, 2.1, -2.1, 2.8, -2.8, 3.1];

/// A moment before, the pusher left as well, though a vertex turns the normal.
const CLEARLY: f64 = 1.65;

/// Every way of leaving every shape, from an angle on.
fn all_leaving(from: f64, mut check: impl FnMut(&str, &StepInput)) {
    let mut n = 0;
    for (name, shape) in shapes() {
        let object = Arc::new(Object::uniform(Arc::new(shape), 0.8).unwrap());
        for center in touching(object.shape()) {
            for beta in BETAS.into_iter().filter(|beta| beta.abs() >= from) {
                if let Some(step) = leaving(&object, &center, beta) {
                    check(&format!("{name} {center:?} β = {beta}"), &step);
                    n += 1;
                }
            }
        }
    }
    assert!(n > 1500, "{n}");
}

fn rig() -> Rig {
    Rig::new(Surface::Ellipsoid, 0.25, 0.25).unwrap()
}

fn gap_at_rest(step: &StepInput, center_w: Vector2<f64>) -> f64 {
    let center = step.pose_wb.inverse_transform_point(&center_w);
    step.object.shape().contact(&center, RADIUS).gap
}

fn rests(channels: &Channels) -> bool {
    let Channels { dx, dy, dtheta, .. } = channels;
    dx.abs() < 1e-12 && dy.abs() < 1e-12 && dtheta.abs() < 1e-11
}

#[test]
fn without_effects_a_leaving_pusher_moves_nothing_and_no_gap_is_made_up() {
    let physics = PushPhysics::new(rig());
    all_leaving(0.0, |name, step| {
        for since_contact in [0.0, 0.01, 1.0, 1e9] {
            for touching in [true, false] {
                let step = StepInput { since_contact, touching, ..step.clone() };
                let found = physics.predict(&step).unwrap();
                let expected = gap_at_rest(&step, step.track.end());
                assert!(rests(&found), "{name} {found:?}");
                assert!(found.gap_start.abs() < 1e-9, "{name} {since_contact} {found:?}");
                assert!((found.gap_end - expected).abs() < 1e-9, "{name} {found:?} {expected}");
            }
        }
    });
}

#[test]
fn off_a_vertex_the_gap_is_that_of_the_pusher() {
    // 1 s of contact before it, at 20 mm/s, is no gap of 10 mm.
    let square = Arc::new(Object::uniform(Arc::new(Shape::square(0.09).unwrap()), 0.8).unwrap());
    let (corner, beta) = (Vector2::new(-0.045, 0.045), 80_f64.to_radians());
    let start = corner + RADIUS * Vector2::new(-0.8, 0.6);
    let end = start + 2e-3 * Vector2::new(beta.cos(), beta.sin());
    let step = StepInput {
        object: square,
        pusher_radius: RADIUS,
        pose_wb: Pose::default(),
        twist_wb: Twist::default(),
        track: Track::straight(start, end, 0.1),
        touching: true,
        since_contact: 1.0,
        run_up: None,
        progress: 0.5,
        session: 0,
    };
    let found = PushPhysics::new(rig()).predict(&step).unwrap();
    assert!(found.gap_start.abs() < 1e-12, "{found:?}");
    assert!((found.gap_end - gap_at_rest(&step, end)).abs() < 1e-12, "{found:?}");
}

#[test]
fn with_any_effect_a_leaving_pusher_moves_nothing() {
    for effect in all() {
        let about = effect.info();
        // With these the pusher is elsewhere than it seems, and need not leave.
        if ["pose-offset", "yaw-offset", "robot-offset", "edge-rounding", "pusher-radius"]
            .contains(&about.id)
        {
            continue;
        }
        let typical = about.typical(&rig());
        let physics = PushPhysics::new(rig()).with(effect, &typical).unwrap();
        let mut index = 0;
        all_leaving(CLEARLY, |name, step| {
            index += 1;
            if index % 7 == 0 {
                let found = physics.predict(step).unwrap();
                assert!(rests(&found), "{} {name} {found:?}", about.id);
            }
        });
    }
}

/// Where a slow, late or soft contact hides what the pusher does, the object still does not move.
#[test]
fn with_latency_and_compliance_the_gaps_are_those_of_a_resting_object() {
    let late =
        |value: f64| PushPhysics::new(rig()).with(by_id("stream-latency").unwrap(), &[value]);
    let soft = PushPhysics::new(rig()).with(by_id("pusher-compliance").unwrap(), &[1e-4]).unwrap();
    for (latency, physics) in [(5e-3, late(5e-3).unwrap()), (0.0, soft)] {
        all_leaving(CLEARLY, |name, step| {
            for since_contact in [0.0, 1.0] {
                let step = StepInput { since_contact, ..step.clone() };
                let found = physics.predict(&step).unwrap();
                let way = found.gap_end - found.gap_start;
                let [start, end] = [step.track.start(), step.track.end()].map(|place| {
                    // Set against the pusher as it was when the object was seen.
                    let shift = latency * step.track.mean_velocity();
                    gap_at_rest(&step, place) - gap_at_rest(&step, step.track.start() - shift)
                });
                let is_vertex = (end - start) - way;
                assert!(rests(&found), "{name} {found:?}");
                assert!(is_vertex.abs() < 2e-5, "{name} {found:?} {start} {end}");
            }
        });
    }
}

/// A pusher that goes `reach` into the object at the left edge of a square and `back` from there.
fn there_and_back(y: f64, reach: f64, back: f64) -> [StepInput; 2] {
    let square = Arc::new(Object::uniform(Arc::new(Shape::square(0.09).unwrap()), 0.8).unwrap());
    let start = Vector2::new(-0.045 - RADIUS, y);
    let at = |x: f64| start + Vector2::new(x, 0.0);
    let points =
        [(0.0, at(0.0)), (reach / SPEED, at(reach)), ((reach + back) / SPEED, at(reach - back))];
    let line = Track::polyline(Arc::new(Polyline::new(&points).unwrap()));
    let step = |track| StepInput {
        object: square.clone(),
        pusher_radius: RADIUS,
        pose_wb: Pose::default(),
        twist_wb: Twist::default(),
        track,
        touching: true,
        since_contact: 1.0,
        run_up: None,
        progress: 0.5,
        session: 0,
    };
    [step(line), step(Track::straight(at(0.0), at(reach), reach / SPEED))]
}

/// Displacement in W and turn times 50 mm.
fn motion(physics: &PushPhysics, step: &StepInput) -> [f64; 3] {
    let found = physics.predict(step).unwrap();
    let along = step.direction_w();
    let moved = found.dx * along + found.dy * planar::perpendicular(&along);
    [moved.x, moved.y, 0.05 * found.dtheta]
}

fn apart(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).abs()).fold(0.0, f64::max)
}

#[test]
fn an_object_stays_where_the_pusher_turned_back() {
    let physics = PushPhysics::new(rig());
    for (y, reach, back) in [(0.0, 4e-3, 4e-3), (0.02, 7e-3, 7e-3), (-0.03, 5.3e-3, 1e-3)] {
        let [both, there] = there_and_back(y, reach, back);
        let error = apart(motion(&physics, &both), motion(&physics, &there));
        assert!(error < 4e-6, "{y} {reach} {back}: {error}");
    }
}

#[test]
fn substeps_are_counted_along_the_path() {
    let physics = |longest: f64| PushPhysics::new(rig().with_longest_substep(longest).unwrap());
    let (coarse, fine) = (physics(1e-3), physics(1e-5));
    let [step, _] = there_and_back(0.02, 4e-3, 4e-3);
    let start = step.track.start();
    // Net way, mean acceleration along and across it times the square of the duration, and path.
    for (way, along, across, path) in [
        (0.0, -0.03, 0.0, 7.5e-3),
        (1e-3, -0.06, 0.0, 15e-3),
        (8e-3, 0.016, 0.0, 8e-3),
        (8e-3, -0.016, 0.0, 8e-3),
        (4e-3, 0.0, 0.03, 8e-3),
        (0.0, -0.04, 0.02, 11e-3),
    ] {
        let duration = 0.5;
        let acceleration = Vector2::new(along, across) / (duration * duration);
        let end = start + Vector2::new(way, 0.0);
        let track = Track::accelerated(start, end, acceleration, duration);
        let step = StepInput { track, ..step.clone() };
        let error = apart(motion(&coarse, &step), motion(&fine, &step));
        println!("{way} {along} {across}: {error:e} m over {path} m");
        // The tolerance that is stated: 4 µm over 4 mm.
        assert!(error < 1e-3 * path, "{way} {along} {across}: {error}");
    }
}

#[test]
fn a_path_that_is_too_long_is_refused_with_its_length() {
    let [step, _] = there_and_back(0.0, 4e-3, 1e-3);
    let far = step.track.start() + Vector2::new(1e6, 0.0);
    let step = StepInput { track: Track::straight(step.track.start(), far, 1.0), ..step };
    let error = PushPhysics::new(rig()).predict(&step).unwrap_err().to_string();
    assert!(error.contains("at most 100000") && error.contains("1000000000"), "{error}");
}
