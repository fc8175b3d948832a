//! The simulator in the slow limit against the quasi-static mechanics, which it never imports.

use dataset::ObjectSpec;
use mechanics::{
    Ellipsoid, LimitSurface, Patch, PathSettings, Pusher, Slider, StraightPath, push_along,
};
use nalgebra::Vector2;
use planar::{Polygon, Pose, Shape};
use plant::{Numerics, PlannedPush, Plant, TipPath, Truth, Variation};

const FRICTION: f64 = 0.25;
const GRAVITY: f64 = 9.81;
const RADIUS: f64 = 0.00475;
/// Slow enough for the slide by v²/2μg to be 1 µm.
const SPEED: f64 = 0.002;
/// Largest difference allowed, of a push; the worst of these is 0.0018.
const MOST: f64 = 0.003;
const PLACE: [f64; 3] = [0.1, -0.2, 0.4];

/// What a slow push does, dynamically against quasi-statically.
struct Comparison {
    /// Difference of the displacements over the displacement.
    place: f64,
    /// Difference of the turns over the turn, or over 0.05 rad where it is less.
    turn: f64,
}

/// All pushes of an object, whose load rests on pads (1) or on a plate like an ellipsoid (0).
fn compare(
    name: &str,
    patch_share: f64,
    surface: impl Fn(&Shape) -> Box<dyn LimitSurface>,
) -> Vec<Comparison> {
    let object = ObjectSpec::mit(name).expect("a known object");
    let mut truth = Truth::default();
    // Stiff, so that the tip gives way by 2 µm at most.
    truth.tip.compliance = 1e-6;
    truth.pressure.patch_share = patch_share;
    let plant = Plant::new(&object, &truth, GRAVITY, &Numerics::default()).expect("a rig");
    let surface = surface(&centered(&object.shape));
    let start = Pose::new(PLACE[0], PLACE[1], PLACE[2]);
    let pushes = paths(&object.shape).into_iter().map(|path| {
        let dynamic = plant.push(&start, &path, &Variation::default()).expect("a push").end_pose();
        let slow = quasi_static(&object.shape, &*surface, &path, &start);
        let moved = (slow.position - start.position).norm();
        let turned = (slow.angle - start.angle).abs();
        Comparison {
            place: (dynamic.position - slow.position).norm() / moved,
            turn: (dynamic.angle - slow.angle).abs() / turned.max(0.05),
        }
    });
    pushes.collect()
}

fn quasi_static(shape: &Shape, surface: &dyn LimitSurface, path: &TipPath, start: &Pose) -> Pose {
    let centroid = shape.centroid();
    let slider = Slider { shape, surface, pose_bs: Pose::new(centroid.x, centroid.y, 0.0) };
    let pusher = Pusher { radius: RADIUS, friction: FRICTION };
    let straight = StraightPath {
        start_w: path.start.into(),
        velocity_w: SPEED * Vector2::from(path.direction),
        duration: path.length / SPEED,
    };
    push_along(&slider, &pusher, &straight, start, &PathSettings::default())
        .expect("a push")
        .pose_wb
}

/// Sticking and sliding pushes of 25 mm.
fn paths(shape: &Shape) -> Vec<TipPath> {
    let pushes = [(0, 0.5, 0.0), (1, 0.3, 0.2), (1, 0.75, -0.5), (0, 0.6, 0.3), (2, 0.2, 0.8)];
    let path = |(edge, p, angle): (usize, f64, f64)| {
        let push = PlannedPush {
            edge: edge % shape.n_edges(),
            p,
            angle,
            speed: SPEED,
            travel: 0.025,
            place: PLACE,
            session: 0,
            repeat: String::new(),
        };
        push.path(shape, RADIUS, 10.0, [0.0, 0.0])
    };
    pushes.into_iter().map(path).collect()
}

/// The shape with its centroid at the origin.
fn centered(shape: &Shape) -> Shape {
    let Shape::Polygon(polygon) = shape else { return shape.clone() };
    let centroid = shape.centroid();
    let vertices = polygon.vertices().iter().map(|vertex| vertex - centroid).collect();
    Shape::Polygon(Polygon::new(vertices).expect("the same polygon"))
}

fn worst(name: &str, comparisons: &[Comparison]) -> f64 {
    let worst = |share: fn(&Comparison) -> f64| comparisons.iter().map(share).fold(0.0, f64::max);
    let (place, turn) = (worst(|c| c.place), worst(|c| c.turn));
    println!("{name}: {:.3} % of the displacement, {:.3} % of the turn", 1e2 * place, 1e2 * turn);
    place.max(turn)
}

#[test]
fn a_slow_push_is_that_of_the_exact_patch() {
    for name in ["rect1", "tri2", "ellip3", "hex"] {
        let patch = |shape: &Shape| -> Box<dyn LimitSurface> {
            Box::new(Patch::uniform(shape, 2.0).unwrap())
        };
        let share = worst(name, &compare(name, 1.0, patch));
        assert!(share < MOST, "{name}: {share}");
    }
}

fn ellipsoid(shape: &Shape) -> Box<dyn LimitSurface> {
    Box::new(Ellipsoid::uniform(shape, 2.0).expect("an ellipsoid"))
}

#[test]
fn on_a_plate_that_dissipates_like_an_ellipsoid_it_is_the_ellipsoids_push() {
    for name in ["rect1", "rect3", "ellip3"] {
        let share = worst(name, &compare(name, 0.0, ellipsoid));
        assert!(share < MOST, "{name}: {share}");
    }
}

#[test]
fn the_two_laws_differ_by_far_more_than_that() {
    let share = worst("rect1", &compare("rect1", 1.0, ellipsoid));
    assert!(share > 0.03, "{share}");
}
