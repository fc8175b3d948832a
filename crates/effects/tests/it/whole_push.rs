//! A whole push of many millimeters, from before the touch to its end, beside the exact push.

use std::sync::Arc;

use effects::{ApproachGap, Object, PushPhysics, Rig, Spread, StepInput, Surface, Track, by_id};
use mechanics::{
    Ellipsoid, PathMotion, PathSettings, Place, Polyline, Pusher, PusherPath, Slider, StraightPath,
    push_along,
};
use nalgebra::Vector2;
use planar::{Pose, Shape, Twist, mit_object};

const RADIUS: f64 = 0.00475;
const FRICTION: f64 = 0.25;
const SPEED: f64 = 0.01;
/// Of a whole push, in m.
const WAY: f64 = 0.05;

fn physics() -> PushPhysics {
    PushPhysics::new(Rig::new(Surface::Ellipsoid, FRICTION, 0.25).unwrap())
}

fn step(shape: &Arc<Shape>, track: Track) -> StepInput {
    StepInput {
        object: Arc::new(Object::uniform(shape.clone(), 0.8).unwrap()),
        pusher_radius: RADIUS,
        pose_wb: Pose::default(),
        twist_wb: Twist::default(),
        track,
        touching: false,
        since_contact: 0.0,
        run_up: None,
        progress: 0.5,
        session: 0,
    }
}

fn exact(shape: &Shape, path: &dyn PusherPath) -> PathMotion {
    let surface = Ellipsoid::uniform(shape, 1.0).unwrap();
    let slider = Slider { shape, surface: &surface, pose_bs: Pose::default() };
    let pusher = Pusher { radius: RADIUS, friction: FRICTION };
    let settings = PathSettings { tolerance: 1e-9, max_travel: 1e-3 };
    push_along(&slider, &pusher, path, &Pose::default(), &settings).unwrap()
}

/// Where the origin gets to, in W, and the turn.
fn moved(physics: &PushPhysics, step: &StepInput) -> (Vector2<f64>, f64) {
    let found = physics.predict(step).unwrap();
    let along = step.direction_w();
    (found.dx * along + found.dy * planar::perpendicular(&along), found.dtheta)
}

/// How far a prediction is from the exact push: m and rad.
fn errors(step: &StepInput, exact: &PathMotion) -> [f64; 2] {
    let (position, turn) = moved(&physics(), step);
    [(position - exact.pose_wb.position).norm(), (turn - exact.pose_wb.angle).abs()]
}

/// A push of the square along +x, `y` off its middle, from `gap` before the touch.
fn of_square(y: f64, gap: f64, way: f64) -> StepInput {
    let start = Vector2::new(-0.045 - RADIUS - gap, y);
    let end = start + Vector2::new(way, 0.0);
    step(&Arc::new(Shape::square(0.09).unwrap()), Track::straight(start, end, way / SPEED))
}

#[test]
fn on_its_way_a_push_is_where_it_would_end_by_then() {
    let (whole, half) = (of_square(0.012, 3e-3, WAY), of_square(0.012, 3e-3, 0.5 * WAY));
    let offset = by_id("friction-center-offset").unwrap();
    let typical = physics().with(offset, &[0.0, 2e-3]).unwrap();
    let differing =
        typical.clone().with_spread("friction-center-offset", "dy", Spread::Sd(4e-3)).unwrap();
    assert!(typical.of_typical_push().is_none());
    let middle = differing.of_typical_push().unwrap();
    assert_eq!(middle.predict(&whole).unwrap(), typical.predict(&whole).unwrap());
    let duration = whole.track.duration();
    for physics in [typical, differing] {
        let path = physics.predict_path(&whole, &[0.0, 0.5 * duration, duration]).unwrap();
        assert_eq!(path[0], whole.pose_wb);
        for (pose, step, within) in [(path[1], &half, 2e-5), (path[2], &whole, 1e-12)] {
            let (position, turn) = moved(&physics, step);
            let off = (pose.position - position).norm().max((pose.angle - turn).abs() * 0.05);
            assert!(off < within, "{off} m");
        }
    }
}

#[test]
fn a_whole_push_starts_before_the_touch_passes_vertices_and_slides_off() {
    let part = |k: usize, step: f64| (k as f64 * step).fract();
    let (mut n_lost, mut n_vertex, mut worst) = (0, 0, [0.0_f64; 2]);
    for name in ["rect1", "tri3", "hex", "ellip2"] {
        let shape = Arc::new(mit_object(name).unwrap().shape);
        for k in 0..100 {
            let (edge, p) = (k % shape.n_edges(), part(k, 0.618));
            let normal = shape.inward_normal_at(edge, p);
            let start_w = shape.point_at(edge, p) - (RADIUS + 3e-3 * part(k, 0.733)) * normal;
            let turn = Pose::new(0.0, 0.0, 2.6 * (part(k, 0.414) - 0.5));
            let velocity_w = SPEED * turn.rotate(&normal);
            let path = StraightPath { start_w, velocity_w, duration: WAY / SPEED };
            let exact = exact(&shape, &path);
            let end = path.position(0, path.duration);
            let found = errors(&step(&shape, Track::straight(start_w, end, path.duration)), &exact);
            worst = [0, 1].map(|i: usize| worst[i].max(found[i]));
            n_lost += usize::from(exact.contact.gap > 2e-3);
            let is_vertex = |place: Place| matches!(place, Place::Vertex(_));
            n_vertex += usize::from(exact.phases.iter().any(|phase| is_vertex(phase.place)));
        }
    }
    assert!(n_lost > 40 && n_vertex > 40, "{n_lost} slid off, {n_vertex} at a vertex");
    // 50 sub-steps; a vertex within one of them costs the most.
    assert!(worst[0] < 5e-5 && worst[1] < 1e-3, "{worst:?}");
}

#[test]
fn a_way_that_never_meets_the_outline_moves_nothing() {
    for step in [of_square(0.051, 0.01, WAY), of_square(0.0, 0.051, WAY)] {
        let found = physics().predict(&step).unwrap();
        assert_eq!([found.dx, found.dy, found.dtheta], [0.0; 3]);
        assert_eq!([found.force_normal, found.force_tangential], [0.0; 2]);
    }
}

#[test]
fn the_way_before_the_touch_is_lost_and_so_is_a_gap_that_was_not_measured() {
    let far = moved(&physics(), &of_square(0.02, 3e-3, WAY));
    let near = moved(&physics(), &of_square(0.02, 0.0, WAY - 3e-3));
    assert!((far.0 - near.0).norm() < 2e-6 && (far.1 - near.1).abs() < 2e-5, "{far:?} {near:?}");
    let gapped = physics().with(ApproachGap, &[2e-3]).unwrap();
    let lost = gapped.predict(&of_square(0.0, 3e-3, WAY)).unwrap();
    assert!((lost.dx - (WAY - 5e-3)).abs() < 1e-9, "{}", lost.dx);
    // What was measured at the start is measured still.
    assert!((gapped.predict(&of_square(0.02, 3e-3, 2e-3)).unwrap().dx).abs() < 1e-15);
}

#[test]
fn a_bent_way_is_followed_from_kink_to_kink() {
    let shape = Arc::new(Shape::square(0.09).unwrap());
    let at = |x: f64, y: f64| Vector2::new(-0.045 - RADIUS + x, y);
    let points = [
        (0.0, at(-2e-3, 0.01)),
        (1.03, at(8.3e-3, 0.013)),
        (2.21, at(0.0193, 0.0)),
        (3.97, at(0.0331, 0.0123)),
    ];
    let line = Polyline::new(&points).unwrap();
    let exact = exact(&shape, &line);
    let found = errors(&step(&shape, Track::kinked(Arc::new(line))), &exact);
    assert!(exact.pose_wb.angle.abs() > 0.1, "{exact:?}");
    assert!(found[0] < 1e-5 && found[1] < 1e-4, "{found:?}");
}
