//! Where the weight rests, a tip at a vertex, a push above the table and a gap before it, against answers
//! found in another way.

use std::sync::Arc;

use effects::{
    ApproachGap, Channels, Effect, FrictionCenterOffset, Object, PressureMap, PushHeight,
    PushPhysics, PusherFriction, Rig, StepInput, SupportPoints, Surface, Track, VertexContact,
    by_id,
};
use mechanics::{LimitSurface, PointSet};
use nalgebra::Vector2;
use planar::{Pose, Shape, Twist};

const SIDE: f64 = 0.09;
const MASS: f64 = 0.8;
const FRICTION: f64 = 0.25;
const RADIUS: f64 = 0.005;
const SPEED: f64 = 0.02;
/// What friction with the table bears, in N.
const LOAD: f64 = FRICTION * MASS * 9.81;

/// A push along +x, turned by `beta`, at the left edge of a square, `y` off its middle.
fn push(y: f64, beta: f64, way: f64) -> StepInput {
    let start = Vector2::new(-0.5 * SIDE - RADIUS, y);
    let end = start + way * Vector2::new(beta.cos(), beta.sin());
    StepInput {
        object: Arc::new(Object::uniform(Arc::new(Shape::square(SIDE).unwrap()), MASS).unwrap()),
        pusher_radius: RADIUS,
        pose_wb: Pose::default(),
        twist_wb: Twist::new(SPEED, 0.0, 0.0),
        track: Track::straight(start, end, way / SPEED),
        touching: true,
        since_contact: 0.0,
        run_up: None,
        progress: 0.5,
        session: 0,
    }
}

fn pushes(way: f64) -> Vec<StepInput> {
    let of = |y: f64| [-0.9, -0.4, 0.0, 0.3, 0.8].map(|beta| push(y, beta, way));
    [-0.035, -0.02, 0.0, 0.01, 0.03].into_iter().flat_map(of).collect()
}

/// Effects with their values.
type Values<'a> = &'a [(Arc<dyn Effect>, &'a [f64])];

fn rig(surface: Surface) -> Rig {
    Rig::new(surface, FRICTION, FRICTION).unwrap()
}

fn with(surface: Surface, effects: Values<'_>) -> PushPhysics {
    effects.iter().fold(PushPhysics::new(rig(surface)), |physics, (effect, values)| {
        physics.with(effect.clone(), values).unwrap()
    })
}

#[track_caller]
fn near(one: &Channels, other: &Channels, tolerance: [f64; 3]) {
    let off = [one.dx - other.dx, one.dy - other.dy, one.dtheta - other.dtheta];
    let is_near = off.iter().zip(tolerance).all(|(off, tolerance)| off.abs() <= tolerance);
    assert!(is_near, "{one:?}\n{other:?}");
}

/// Places and shares of four points, and none of two more.
const FOUR: [f64; 18] = [
    0.038, 0.031, 0.35, -0.036, 0.040, 0.2, -0.041, -0.033, 0.3, 0.030, -0.037, 0.15, //
    0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
];

#[test]
fn points_push_as_the_exact_surface_of_a_point_set_does() {
    let points = FOUR.chunks_exact(3).filter(|point| point[2] > 0.0);
    let points = points.map(|point| (Vector2::new(point[0], point[1]), point[2] * LOAD));
    let exact: Arc<dyn LimitSurface> = Arc::new(PointSet::new(points).unwrap());
    let exact = PushPhysics::new(rig(Surface::Given(exact)));
    let points = with(Surface::Ellipsoid, &[(Arc::new(SupportPoints), &FOUR)]);
    for step in pushes(1e-3) {
        // Feet of half a millimeter are no points where the object turns about one of them.
        let (one, other) = (points.predict(&step).unwrap(), exact.predict(&step).unwrap());
        near(&one, &other, [3e-6, 3e-6, 1e-4]);
    }
}

#[test]
fn a_map_of_uniform_pressure_is_near_the_uniform_patch() {
    let object = Object::uniform(Arc::new(Shape::square(SIDE).unwrap()), MASS).unwrap();
    let shares: Vec<f64> = object.cells().iter().map(|cell| cell.share).collect();
    let map = with(Surface::Ellipsoid, &[(Arc::new(PressureMap), &shares)]);
    let patch = PushPhysics::new(rig(Surface::UniformPatch));
    for step in pushes(4e-3) {
        let (one, other) = (map.predict(&step).unwrap(), patch.predict(&step).unwrap());
        near(&one, &other, [2e-5, 2e-5, 1e-3]);
    }
}

#[test]
fn a_tip_near_a_vertex_is_held_from_sliding_inwards_alone() {
    let caught = with(Surface::Ellipsoid, &[(Arc::new(VertexContact), &[2e-3])]);
    let rough = with(Surface::Ellipsoid, &[(Arc::new(PusherFriction), &[2.0])]);
    let plain = PushPhysics::new(rig(Surface::Ellipsoid));
    let predict = |physics: &PushPhysics, step: &StepInput| physics.predict(step).unwrap();
    for side in [1.0, -1.0] {
        let inwards = push(side * 0.044, -side * 0.6, 4e-3);
        near(&predict(&caught, &inwards), &predict(&rough, &inwards), [1e-12; 3]);
        let is_plain =
            |step: &StepInput| near(&predict(&caught, step), &predict(&plain, step), [1e-12; 3]);
        is_plain(&push(side * 0.044, side * 0.6, 4e-3));
        is_plain(&push(side * 0.040, -side * 0.6, 4e-3));
        let differs = predict(&caught, &inwards).dtheta - predict(&plain, &inwards).dtheta;
        assert!(differs.abs() > 1e-3, "{differs}");
    }
}

#[test]
fn a_push_above_the_table_moves_the_center_of_friction_by_its_lean() {
    let height = 0.03;
    for surface in [Surface::Ellipsoid, Surface::UniformPatch] {
        for step in pushes(1e-6) {
            let high = with(surface.clone(), &[(Arc::new(PushHeight), &[height])]);
            let leaning = high.predict(&step).unwrap();
            // The edge's normal is +x of the body, its tangent +y.
            let force = Vector2::new(leaning.force_normal, leaning.force_tangential);
            let lean = height / (MASS * 9.81) * force;
            let moved = with(surface.clone(), &[(Arc::new(FrictionCenterOffset), lean.as_slice())]);
            near(&leaning, &moved.predict(&step).unwrap(), [1e-12, 1e-12, 1e-10]);
        }
    }
}

#[test]
fn a_push_above_four_feet_presses_on_those_ahead() {
    // By statics: h f of moment on feet 2a apart adds h f/(4a) to each of the two ahead.
    let a = 0.04;
    let square: Vec<f64> = [(a, a), (-a, a), (-a, -a), (a, -a), (0.0, 0.0), (0.0, 0.0)]
        .iter()
        .enumerate()
        .flat_map(|(k, (x, y))| [*x, *y, if k < 4 { 0.25 } else { 0.0 }])
        .collect();
    let (height, step) = (0.02, push(0.01, 0.0, 1e-6));
    let high = with(
        Surface::Ellipsoid,
        &[(Arc::new(SupportPoints), &square), (Arc::new(PushHeight), &[height])],
    );
    let leaning = high.predict(&step).unwrap();
    let force = Vector2::new(leaning.force_normal, leaning.force_tangential);
    let more = height / (4.0 * a * MASS * 9.81) * force;
    let by_hand: Vec<f64> = square
        .chunks_exact(3)
        .flat_map(|p| {
            let lean = p[0].signum() * more.x + p[1].signum() * more.y;
            [p[0], p[1], if p[2] > 0.0 { p[2] + lean } else { 0.0 }]
        })
        .collect();
    // Shares that lean are linear in the place to first order.
    let known =
        with(Surface::Ellipsoid, &[(Arc::new(SupportPoints), &by_hand)]).predict(&step).unwrap();
    near(&leaning, &known, [2e-8, 2e-8, 2e-7]);
    let plain =
        with(Surface::Ellipsoid, &[(Arc::new(SupportPoints), &square)]).predict(&step).unwrap();
    assert!((leaning.dtheta - plain.dtheta).abs() > 1e-7, "{leaning:?} {plain:?}");
}

#[test]
fn a_gap_before_the_touch_is_way_that_is_lost() {
    let step = push(0.0, 0.0, 4e-3);
    let late =
        with(Surface::Ellipsoid, &[(Arc::new(ApproachGap), &[1.5e-3])]).predict(&step).unwrap();
    assert!((late.dx - 2.5e-3).abs() < 1e-9, "{late:?}");
    assert!((late.gap_start - 1.5e-3).abs() < 1e-12 && late.gap_end.abs() < 1e-9, "{late:?}");
    // Of a push that has gone on for long, nothing is lost any more.
    let later = StepInput { since_contact: 1.0, ..step };
    let late =
        with(Surface::Ellipsoid, &[(Arc::new(ApproachGap), &[1.5e-3])]).predict(&later).unwrap();
    assert!((late.dx - 4e-3).abs() < 1e-12, "{late:?}");
}

#[test]
fn a_ratio_is_within_its_range_wherever_a_search_stands() {
    let about = by_id("table-anisotropy").unwrap().info();
    let ends =
        about.coordinates(&rig(Surface::Ellipsoid)).iter().map(|c| c.range.1).collect::<Vec<_>>();
    about.check(&about.from_coordinates(&ends)).unwrap();
}
