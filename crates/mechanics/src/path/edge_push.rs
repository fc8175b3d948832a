//! A straight push at the inside of one edge, without allocation.

mod batch;
mod ode;

use nalgebra::Vector2;
use planar::{Pose, Shape, perpendicular};

use self::batch::{LANES, integrate_batch};
use self::ode::{EdgeContact, EdgeContactOde, sin_cos};
use crate::{Ellipsoid, Pusher};

/// What [`crate::push_along`] does, for the pushes that planning asks for millions of times: straight
/// ones of a convex polygon on an upright ellipsoid, while the pusher keeps one edge and sticks or
/// slides.
///
/// The pusher's center is known at any time, so the object's pose follows from its turn φ and the
/// place s of the contact along the edge. Two equations remain: with x < 0 the edge's distance from the
/// center of friction, v the pusher's velocity in the edge's axes (n inward, t to its left),
///
/// - sticking: (V, ω) with f = V, fₙ = ((c² + x²) vₙ + x s vₜ)/(c² + x² + s²), fₜ likewise, and
///   ω = (x vₜ − s vₙ)/(c² + x² + s²);
/// - sliding, f along the edge (1, ±μ) of the friction cone: fₙ = c² vₙ/(c² + s² ∓ μ x s),
///   ω = (± μ x − s) fₙ/c².
///
/// The same steps and tolerance; no history is kept.
#[derive(Clone, Debug)]
pub struct EdgePush {
    edges: Vec<Edge>,
    /// The center of friction, in m, frame B.
    center_b: Vector2<f64>,
    /// Of c = Mmax/Fmax, in m².
    length_squared: f64,
}

/// An edge in axes along its inward normal n and its left t, from the center of friction.
#[derive(Clone, Copy, Debug)]
struct Edge {
    normal_b: Vector2<f64>,
    /// Place of its line along n, in m.
    x: f64,
    /// Its ends along t, in m.
    ends: [f64; 2],
}

/// A straight push that begins at an edge, seen from the body at its start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StraightPush {
    /// The edge whose inside the pusher is to meet, from 0.
    pub edge: usize,
    /// The pusher's center, in m, frame B.
    pub start_b: Vector2<f64>,
    /// Its motion, a unit vector in B.
    pub direction_b: Vector2<f64>,
    /// How far it moves, in m.
    pub distance: f64,
}

/// Gap below which pusher and object touch, in m.
const TOUCH: f64 = 1e-9;

impl EdgePush {
    /// Of a shape whose slider frame S is at `pose_bs`; none for one that is no convex polygon, or an
    /// ellipsoid that is not upright and round.
    pub fn new(shape: &Shape, ellipsoid: &Ellipsoid, pose_bs: &Pose) -> Option<Self> {
        let (Shape::Polygon(polygon), a) = (shape, ellipsoid.matrix()) else { return None };
        let is_upright = a.m11 == a.m22 && a.m12 == 0.0 && a.m13 == 0.0 && a.m23 == 0.0;
        if !(is_upright && polygon.is_convex()) {
            return None;
        }
        let center_b = pose_bs.position;
        let edge = |(from, to): (Vector2<f64>, Vector2<f64>)| {
            let normal_b = perpendicular(&(to - from)).normalize();
            let left_b = perpendicular(&normal_b);
            let [from, to] = [from - center_b, to - center_b];
            // Edges run counter-clockwise, against their left.
            Edge { normal_b, x: normal_b.dot(&from), ends: [left_b.dot(&to), left_b.dot(&from)] }
        };
        let edges = polygon.edges().map(edge).collect();
        Some(Self { edges, center_b, length_squared: a.m11 / a.m33 })
    }

    /// The motion of B, its end seen from its start.
    ///
    /// None where the pusher does not stay inside of the edge or does not press:
    /// [`crate::push_along`] takes all that.
    pub fn push(&self, pusher: &Pusher, push: &StraightPush) -> Option<Pose> {
        let ode = self.begin(pusher, push)?;
        Some(self.end(&ode, push, ode.integrate()?))
    }

    /// The motions of many pushes by one pusher, as [`EdgePush::push`] has each of them, to the bit,
    /// in a fraction of its time: several run beside each other in vector registers.
    pub fn push_all(&self, pusher: &Pusher, pushes: &[StraightPush]) -> Vec<Option<Pose>> {
        let mut moved = Vec::with_capacity(pushes.len());
        for pushes in pushes.chunks(LANES) {
            let mut odes = [None; LANES];
            for (ode, push) in odes.iter_mut().zip(pushes) {
                *ode = self.begin(pusher, push);
            }
            let ends = integrate_batch(&odes, self.length_squared, pusher.friction);
            moved.extend(odes.iter().zip(ends).zip(pushes).map(|((ode, last), push)| {
                let ode = ode.as_ref()?;
                Some(self.end(ode, push, last.or_else(|| ode.integrate())?))
            }));
        }
        moved
    }

    /// The motion from where the pusher touches.
    #[inline]
    fn begin(&self, pusher: &Pusher, push: &StraightPush) -> Option<EdgeContactOde> {
        let &Edge { normal_b, x, ends } = self.edges.get(push.edge)?;
        let left_b = perpendicular(&normal_b);
        let in_edge = |v: &Vector2<f64>| Vector2::new(normal_b.dot(v), left_b.dot(v));
        let direction = in_edge(&push.direction_b);
        let start = in_edge(&(push.start_b - self.center_b));
        let center_x = x - pusher.radius;
        // An object that overlaps the pusher is moved out of it along the normal.
        let gap = center_x - start.x;
        let free = if gap > TOUCH { gap / direction.x } else { 0.0 };
        if !(free >= 0.0 && free < push.distance) {
            return None;
        }
        let (length_squared, friction) = (self.length_squared, pusher.friction);
        Some(EdgeContactOde {
            contact: EdgeContact { x, ends, length_squared, friction, direction, center_x },
            normal_b,
            start,
            first: start.y + free * direction.y,
            length: push.distance - free,
        })
    }

    /// The motion of B to the last state: where the pusher's center is tells where the object is.
    #[inline]
    fn end(&self, ode: &EdgeContactOde, push: &StraightPush, last: Vector2<f64>) -> Pose {
        let (EdgeContact { direction, center_x, .. }, normal_b) = (&ode.contact, &ode.normal_b);
        let (sin, cos) = sin_cos(last.y);
        let center = ode.start + push.distance * direction;
        let held = Vector2::new(cos * center_x - sin * last.x, sin * center_x + cos * last.x);
        let moved = center - held;
        let position = moved.x * normal_b + moved.y * perpendicular(normal_b);
        let center_b = self.center_b;
        let turned =
            Vector2::new(cos * center_b.x - sin * center_b.y, sin * center_b.x + cos * center_b.y);
        Pose { position: position + center_b - turned, angle: last.y }
    }
}

#[cfg(test)]
mod tests {
    use super::{EdgePush, StraightPush};
    use crate::{Ellipsoid, PathMotion, PathSettings, Pusher, Slider, StraightPath, push_along};
    use planar::{MIT_NAMES, Pose, Shape, mit_object};
    use proptest::prelude::{ProptestConfig, prop_assert, proptest};
    use std::cell::Cell;

    /// One push by both ways.
    fn both(
        shape: &Shape,
        friction: f64,
        (edge, p, beta): (usize, f64, f64),
        (gap, distance): (f64, f64),
    ) -> (Option<Pose>, PathMotion) {
        let center = shape.centroid();
        let surface = Ellipsoid::new(1.0, shape.mean_distance(&center)).unwrap();
        let pose_bs = Pose::new(center.x, center.y, 0.4);
        let pusher = Pusher { radius: 0.005, friction };
        let normal = shape.inward_normal_at(edge, p);
        let start = shape.point_at(edge, p) - (pusher.radius + gap) * normal;
        let direction = Pose::new(0.0, 0.0, beta).rotate(&normal);
        let path = StraightPath { start_w: start, velocity_w: direction, duration: distance };
        let slider = Slider { shape, surface: &surface, pose_bs };
        let origin = Pose::default();
        let whole = push_along(&slider, &pusher, &path, &origin, &PathSettings::default()).unwrap();
        let push = StraightPush { edge, start_b: start, direction_b: direction, distance };
        let fast =
            EdgePush::new(shape, &surface, &pose_bs).and_then(|fast| fast.push(&pusher, &push));
        (fast, whole)
    }

    #[test]
    fn it_goes_where_the_general_push_goes_and_takes_most_pushes() {
        let (n_all, n_taken) = (Cell::new(0), Cell::new(0));
        proptest!(ProptestConfig::with_cases(400), |(
            name in 0..MIT_NAMES.len(), edge in 0..8usize, p in 0.1..0.9f64, beta in -1.2..1.2f64,
            friction in 0.0..0.6f64, gap in -4e-4..4e-4f64, distance in 1e-3..8e-3f64)| {
            let shape = mit_object(MIT_NAMES[name]).unwrap().shape;
            let edge = edge % shape.n_edges();
            let (fast, whole) = both(&shape, friction, (edge, p, beta), (gap, distance));
            n_all.set(n_all.get() + usize::from(matches!(&shape, Shape::Polygon(outline) if outline.is_convex())));
            let whole = whole.pose_wb;
            if let Some(fast) = fast {
                n_taken.set(n_taken.get() + 1);
                // Both are within 10 nm a step.
                prop_assert!((fast.position - whole.position).norm() < 2e-8, "{fast:?} {whole:?}");
                prop_assert!((fast.angle - whole.angle).abs() < 1e-6, "{fast:?} {whole:?}");
            }
        });
        assert!(10 * n_taken.get() > 9 * n_all.get(), "{} of {}", n_taken.get(), n_all.get());
    }

    #[test]
    fn a_push_that_begins_to_slide_or_to_stick_is_followed_too() {
        let square = Shape::square(0.09).unwrap();
        let (mut n_changes, mut n_taken) = (0, 0);
        for k in 0..4000 {
            // About the edge of the friction cone, where the turn of the object decides.
            let (p, beta) =
                (0.15 + 0.7 * (f64::from(k) * 0.618).fract(), 0.2 + 1e-4 * f64::from(k));
            let (fast, whole) = both(&square, 0.3, (1, p, beta), (0.0, 0.004));
            if whole.phases.len() < 2 {
                continue;
            }
            n_changes += 1;
            let Some(fast) = fast else { continue };
            n_taken += 1;
            let pose = whole.pose_wb;
            assert!((fast.position - pose.position).norm() < 4e-8, "{p} {beta}: {fast:?} {pose:?}");
            assert!((fast.angle - pose.angle).abs() < 1e-6, "{p} {beta}: {fast:?} {pose:?}");
        }
        assert!(n_changes > 30 && n_taken == n_changes, "{n_taken} of {n_changes}");
    }

    #[test]
    fn vertices_curves_and_departures_are_left_to_the_general_push() {
        let square = Shape::square(0.09).unwrap();
        for (place, gap, distance) in [
            ((1, 0.999, -0.9), 0.0, 0.008),
            ((1, 0.5, 1.7), 0.0, 0.004),
            ((1, 0.5, 0.0), 0.002, 0.001),
        ] {
            assert_eq!(both(&square, 0.0, place, (gap, distance)).0, None, "{place:?}");
        }
        let disc = mit_object("ellip1").unwrap().shape;
        assert_eq!(both(&disc, 0.2, (0, 0.3, 0.1), (0.0, 0.004)).0, None);
    }

    #[test]
    fn many_pushes_at_once_go_where_each_goes_to_the_bit() {
        for name in MIT_NAMES {
            let shape = mit_object(name).unwrap().shape;
            let center = shape.centroid();
            let surface = Ellipsoid::new(1.0, shape.mean_distance(&center)).unwrap();
            let pose_bs = Pose::new(center.x, center.y, 0.0);
            let Some(fast) = EdgePush::new(&shape, &surface, &pose_bs) else { continue };
            let pusher = Pusher { radius: 0.005, friction: 0.3 };
            let part = |k: usize, step: f64| (k as f64 * step).fract();
            let push = |k: usize| {
                let (edge, p) = (k % shape.n_edges(), part(k, 0.618));
                let normal = shape.inward_normal_at(edge, p);
                let away = pusher.radius + 4e-4 * (part(k, 0.733) - 0.5);
                let direction_b = Pose::new(0.0, 0.0, 3.2 * (part(k, 0.414) - 0.5)).rotate(&normal);
                let start_b = shape.point_at(edge, p) - away * normal;
                StraightPush { edge, start_b, direction_b, distance: 0.03 * part(k, 0.323) }
            };
            let pushes: Vec<_> = (0..1003).map(push).collect();
            let each: Vec<_> = pushes.iter().map(|push| fast.push(&pusher, push)).collect();
            assert_eq!(fast.push_all(&pusher, &pushes), each, "{name}");
            let n_taken = each.iter().flatten().count();
            assert!(n_taken > 500 && n_taken < 1003, "{name}: {n_taken}");
        }
    }
}
