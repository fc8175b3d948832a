//! Without effects, a step is the quasi-static push along its way.

use effects::{Channels, Object, PushPhysics, Rig, StepInput, Surface, Track};
use mechanics::{
    Ellipsoid, LimitSurface, Patch, PathSettings, Pusher, Slider, StraightPath, push_along,
};
use nalgebra::Vector2;
use planar::{Pose, Shape, Twist, mit_object};
use std::sync::Arc;

const RADIUS: f64 = 0.00475;
const PUSHER_FRICTION: f64 = 0.25;
const SUPPORT_FRICTION: f64 = 0.3;

fn step(shape: &Arc<Shape>, edge: usize, p: f64, beta: f64, way: f64) -> StepInput {
    let pose_wb = Pose::new(0.3, -0.1, 0.7);
    let normal = shape.inward_normal_at(edge, p);
    let start_b = shape.point_at(edge, p) - RADIUS * normal;
    let start = pose_wb.transform_point(&start_b);
    let end = start + pose_wb.rotate(&Pose::new(0.0, 0.0, beta).rotate(&(way * normal)));
    StepInput {
        object: Arc::new(Object::uniform(shape.clone(), 0.8).unwrap()),
        pusher_radius: RADIUS,
        pose_wb,
        twist_wb: Twist::default(),
        track: Track::straight(start, end, 0.2),
        touching: true,
        since_contact: 1.0,
        run_up: None,
        progress: 0.5,
        session: 0,
    }
}

fn exact(step: &StepInput, surface: &dyn LimitSurface, center: Vector2<f64>) -> Channels {
    let object = &step.object;
    let slider =
        Slider { shape: object.shape(), surface, pose_bs: Pose::new(center.x, center.y, 0.0) };
    let pusher = Pusher { radius: RADIUS, friction: PUSHER_FRICTION };
    let duration = step.track.duration();
    let path = StraightPath {
        start_w: step.track.start(),
        velocity_w: step.track.mean_velocity(),
        duration,
    };
    let motion =
        push_along(&slider, &pusher, &path, &step.pose_wb, &PathSettings::default()).unwrap();
    let along = step.direction_w();
    let moved = motion.pose_wb.position - step.pose_wb.position;
    Channels {
        dx: along.dot(&moved),
        dy: planar::perpendicular(&along).dot(&moved),
        dtheta: motion.pose_wb.angle - step.pose_wb.angle,
        force_normal: motion.mean_normal_force,
        force_tangential: motion.mean_tangential_force,
        gap_start: 0.0,
        gap_end: 0.0,
    }
}

/// Largest difference of place (m), of turn times 50 mm, and of force (N).
fn worst(kind: &Surface, name: &str) -> (f64, f64) {
    let shape = Arc::new(mit_object(name).unwrap().shape);
    let rig = Rig::new(kind.clone(), PUSHER_FRICTION, SUPPORT_FRICTION).unwrap();
    let physics = PushPhysics::new(rig);
    let f_max = SUPPORT_FRICTION * 0.8 * 9.81;
    let center = shape.centroid();
    let ellipsoid = Ellipsoid::new(f_max, f_max * shape.mean_distance(&center)).unwrap();
    let patch = Patch::uniform(&shape, f_max).unwrap();
    let (mut place, mut force) = (0.0_f64, 0.0_f64);
    for edge in 0..shape.n_edges().min(3) {
        for p in [0.12, 0.3, 0.5, 0.85] {
            for beta in [-0.6, -0.2, 0.0, 0.35, 0.7] {
                let step = step(&shape, edge, p, beta, 4e-3);
                let expected = match kind {
                    Surface::Ellipsoid => exact(&step, &ellipsoid, center),
                    _ => exact(&step, &patch, Vector2::zeros()),
                };
                let got = physics.predict(&step).unwrap();
                let moved = Vector2::new(got.dx - expected.dx, got.dy - expected.dy);
                place = place.max(moved.norm()).max(0.05 * (got.dtheta - expected.dtheta).abs());
                force = force.max((got.force_normal - expected.force_normal).abs());
                force = force.max((got.force_tangential - expected.force_tangential).abs());
                assert!(got.gap_start.abs() < 1e-15 && got.gap_end.abs() < 1e-15);
            }
        }
    }
    println!("{name} {kind:?}: {place:e} m, {force:e} N");
    (place, force)
}

#[test]
fn four_substeps_follow_the_push_on_an_ellipsoid() {
    for name in ["rect1", "rect3", "tri2", "hex", "ellip2"] {
        let (place, force) = worst(&Surface::Ellipsoid, name);
        assert!(place < 4e-6 && force < 2e-2, "{name}: {place} m, {force} N");
    }
}

#[test]
fn four_substeps_follow_the_push_on_the_exact_surface() {
    for name in ["rect1", "tri2"] {
        let (place, force) = worst(&Surface::UniformPatch, name);
        assert!(place < 4e-6 && force < 2e-2, "{name}: {place} m, {force} N");
    }
}
