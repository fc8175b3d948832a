//! A straight push at the inside of one edge, without allocation.

use crate::runge_kutta::{Step, step};
use crate::{Ellipsoid, Pusher};
use nalgebra::{Vector2, Vector3};
use planar::{Pose, Shape, perpendicular};

/// What [`crate::push_along`] does, for the pushes that planning asks for millions of times: straight
/// ones of a convex polygon on an ellipsoid, while the pusher keeps one edge and sticks or slides.
///
/// The same equations, steps and tolerance; no history is kept and nothing is allocated.
#[derive(Clone, Debug)]
pub struct EdgePush {
    /// Frame S.
    edges: Vec<Edge>,
    /// A of the ellipsoid, upper triangle by rows.
    matrix: [f64; 6],
    pose_bs: Pose,
    characteristic_length: f64,
}

#[derive(Clone, Copy, Debug)]
struct Edge {
    from: Vector2<f64>,
    tangent: Vector2<f64>,
    length: f64,
}

/// How the pusher moves, frame S at the start.
#[derive(Clone, Copy)]
struct Way {
    start: Vector2<f64>,
    direction: Vector2<f64>,
    edge: Edge,
    radius: f64,
    friction: f64,
}

/// Which way the pusher slides: 0 where it sticks.
type Sliding = i8;

/// Error of a step, in m; an angle counts times the characteristic length.
const TOLERANCE: f64 = 1e-8;
/// Longest travel of the pusher in a step, in m.
const MAX_TRAVEL: f64 = 5e-3;
/// Gap below which pusher and object touch, in m.
const TOUCH: f64 = 1e-9;
/// Most halvings of a step.
const MOST_HALVINGS: u32 = 3;

impl EdgePush {
    /// Of a shape whose slider frame S is at `pose_bs`; none for one that is no convex polygon.
    pub fn new(shape: &Shape, ellipsoid: &Ellipsoid, pose_bs: &Pose) -> Option<Self> {
        let Shape::Polygon(polygon) = shape else { return None };
        if !polygon.is_convex() {
            return None;
        }
        let edge = |(from, to): (Vector2<f64>, Vector2<f64>)| {
            let from = pose_bs.inverse_transform_point(&from);
            let along = pose_bs.inverse_transform_point(&to) - from;
            let length = along.norm();
            Edge { from, tangent: along / length, length }
        };
        let a = ellipsoid.matrix();
        Some(Self {
            edges: polygon.edges().map(edge).collect(),
            matrix: [a.m11, a.m12, a.m13, a.m22, a.m23, a.m33],
            pose_bs: *pose_bs,
            characteristic_length: (0.5 * (a.m11 + a.m22) / a.m33).sqrt(),
        })
    }

    /// The motion of B, its end seen from its start, while a pusher's center goes from `start_b` by
    /// `distance` (both in m) along the unit vector `direction_b`.
    ///
    /// None where the pusher does not stay inside of `edge`, does not press, or changes between
    /// sticking and sliding: [`crate::push_along`] takes all that.
    pub fn push(
        &self,
        pusher: &Pusher,
        edge: usize,
        start_b: &Vector2<f64>,
        direction_b: &Vector2<f64>,
        distance: f64,
    ) -> Option<Pose> {
        let way = Way {
            start: self.pose_bs.inverse_transform_point(start_b),
            direction: self.pose_bs.inverse_rotate(direction_b),
            edge: *self.edges.get(edge)?,
            radius: pusher.radius,
            friction: pusher.friction,
        };
        let (begin, mut state) = way.touch()?;
        if begin >= distance {
            return None;
        }
        let n_least = ((distance - begin) / MAX_TRAVEL).ceil().max(1.0) as usize;
        let first = self.slope(&way, begin, &state)?.0;
        let end = (0..=MOST_HALVINGS).find_map(|halvings| {
            let n = n_least << halvings;
            let h = (distance - begin) / n as f64;
            let mut now = state;
            for k in 0..n {
                now = self.stepped(&way, begin + h * k as f64, h, &now, first)?;
            }
            Some(now)
        });
        state = end?;
        let pose_ss = Pose::new(state.x, state.y, state.z);
        Some(self.pose_bs * pose_ss * self.pose_bs.inverse())
    }

    /// The state after a step; none if it is too long, or if the contact changes on the way.
    fn stepped(
        &self,
        way: &Way,
        at: f64,
        h: f64,
        state: &Vector3<f64>,
        sliding: Sliding,
    ) -> Option<Vector3<f64>> {
        let slope = |at: f64, state: &Vector3<f64>| {
            let same = self.slope(way, at, state).filter(|(kind, _)| *kind == sliding);
            same.map(|(_, slope)| slope).ok_or(Changed)
        };
        let here = slope(at, state).ok()?;
        let Step { end, error } = step(at, state, &here, h, slope).ok()?;
        let off = error.xy().norm().hypot(self.characteristic_length * error.z);
        (off <= TOLERANCE).then(|| way.closed(at + h, end))
    }

    /// Whether and where the pusher slides, and the velocity of S at unit speed of the pusher; none
    /// where it is beside the edge or does not press.
    ///
    /// With J the Jacobian of the contact point, a contact force f moves that point with J A Jᵀ f, up
    /// to a factor, as in [`crate::predict`].
    fn slope(&self, way: &Way, at: f64, state: &Vector3<f64>) -> Option<(Sliding, Vector3<f64>)> {
        let (sin, cos) = sin_cos(state.z);
        let place = way.place((sin, cos), at, state);
        let Edge { tangent, length, .. } = way.edge;
        if !(place.along > 0.0 && place.along < length) {
            return None;
        }
        let normal = perpendicular(&tangent);
        let v = turned_back((sin, cos), &way.direction);
        let approach = normal.dot(&v);
        if approach <= 0.0 {
            return None;
        }
        let [xx, xy, xt, yy, yt, tt] = self.matrix;
        let p = place.point;
        // The motions that unit forces along x and y make: the columns of A Jᵀ.
        let by_x = Vector3::new(xx - p.y * xt, xy - p.y * yt, xt - p.y * tt);
        let by_y = Vector3::new(xy + p.x * xt, yy + p.x * yt, yt + p.x * tt);
        let at_contact =
            |twist: &Vector3<f64>| Vector2::new(twist.x - p.y * twist.z, twist.y + p.x * twist.z);
        let (g_x, g_y) = (at_contact(&by_x), at_contact(&by_y));
        let determinant = g_x.x * g_y.y - g_x.y * g_y.x;
        let sticking =
            Vector2::new(g_y.y * v.x - g_y.x * v.y, g_x.x * v.y - g_x.y * v.x) / determinant;
        // The edge's own tangent runs counter-clockwise: that of a contact is its opposite.
        let (normal_part, left) = (normal.dot(&sticking), -tangent.dot(&sticking));
        let (sliding, f) = if left.abs() <= way.friction * normal_part {
            (0, sticking)
        } else {
            let side = left.signum();
            let edge = normal - side * way.friction * tangent;
            (side as Sliding, edge * (approach / normal.dot(&(edge.x * g_x + edge.y * g_y))))
        };
        let twist = f.x * by_x + f.y * by_y;
        let linear = turned((sin, cos), &twist.xy());
        Some((sliding, Vector3::new(linear.x, linear.y, twist.z)))
    }
}

/// The contact is no longer of its kind.
struct Changed;

/// Where the pusher is at the edge, frame S.
struct AtEdge {
    /// From the edge's start, in m.
    along: f64,
    /// Nearest point of the edge's line, in m.
    point: Vector2<f64>,
    gap: f64,
}

impl Way {
    fn place(&self, turn: (f64, f64), at: f64, state: &Vector3<f64>) -> AtEdge {
        let center = turned_back(turn, &(self.start + at * self.direction - state.xy()));
        let Edge { from, tangent, .. } = self.edge;
        let arm = center - from;
        let along = tangent.dot(&arm);
        let outward = -perpendicular(&tangent).dot(&arm);
        AtEdge { along, point: from + along * tangent, gap: outward - self.radius }
    }

    /// The pusher's way until it touches, and the state then: moved out of a pusher that overlaps.
    fn touch(&self) -> Option<(f64, Vector3<f64>)> {
        let still = Vector3::zeros();
        let gap = self.place((0.0, 1.0), 0.0, &still).gap;
        if gap <= TOUCH {
            return Some((0.0, self.closed(0.0, still)));
        }
        let approach = perpendicular(&self.edge.tangent).dot(&self.direction);
        (approach > 0.0).then(|| (gap / approach, still))
    }

    /// The state with the gap closed along the normal.
    fn closed(&self, at: f64, mut state: Vector3<f64>) -> Vector3<f64> {
        let turn = sin_cos(state.z);
        let gap = self.place(turn, at, &state).gap;
        let shift = turned(turn, &(-gap * perpendicular(&self.edge.tangent)));
        state.x += shift.x;
        state.y += shift.y;
        state
    }
}

fn turned((sin, cos): (f64, f64), v: &Vector2<f64>) -> Vector2<f64> {
    Vector2::new(cos * v.x - sin * v.y, sin * v.x + cos * v.y)
}

fn turned_back((sin, cos): (f64, f64), v: &Vector2<f64>) -> Vector2<f64> {
    Vector2::new(cos * v.x + sin * v.y, cos * v.y - sin * v.x)
}

/// Sine and cosine, to rounding by their series for the small turns of a step.
fn sin_cos(angle: f64) -> (f64, f64) {
    if angle.abs() > 0.3 {
        return angle.sin_cos();
    }
    let x = angle * angle;
    let sin =
        1.0 - x / 6.0 * (1.0 - x / 20.0 * (1.0 - x / 42.0 * (1.0 - x / 72.0 * (1.0 - x / 110.0))));
    let cos = 1.0
        - x / 2.0
            * (1.0
                - x / 12.0
                    * (1.0 - x / 30.0 * (1.0 - x / 56.0 * (1.0 - x / 90.0 * (1.0 - x / 132.0)))));
    (angle * sin, cos)
}

#[cfg(test)]
mod tests {
    use super::{EdgePush, sin_cos};
    use crate::{Ellipsoid, PathSettings, Pusher, Slider, StraightPath, push_along};
    use nalgebra::Vector2;
    use planar::{MIT_NAMES, Pose, Shape, mit_object};
    use proptest::prelude::{ProptestConfig, prop_assert, proptest};
    use proptest::test_runner::RngSeed;
    use std::cell::Cell;

    /// One push by both ways.
    fn both(
        shape: &Shape,
        friction: f64,
        (edge, p, beta): (usize, f64, f64),
        (gap, distance): (f64, f64),
    ) -> (Option<Pose>, Pose) {
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
        let fast = EdgePush::new(shape, &surface, &pose_bs)
            .and_then(|fast| fast.push(&pusher, edge, &start, &direction, distance));
        (fast, whole.pose_wb)
    }

    #[test]
    fn it_goes_where_the_general_push_goes_and_takes_most_pushes() {
        let (n_all, n_taken) = (Cell::new(0), Cell::new(0));
        proptest!(ProptestConfig {
            cases: 400, failure_persistence: None, rng_seed: RngSeed::Fixed(3), ..Default::default()
        }, |(name in 0..MIT_NAMES.len(), edge in 0..8usize, p in 0.1..0.9f64, beta in -1.2..1.2f64,
             friction in 0.0..0.6f64, gap in -4e-4..4e-4f64, distance in 1e-3..8e-3f64)| {
            let shape = mit_object(MIT_NAMES[name]).unwrap().shape;
            let edge = edge % shape.n_edges();
            let (fast, whole) = both(&shape, friction, (edge, p, beta), (gap, distance));
            n_all.set(n_all.get() + usize::from(matches!(&shape, Shape::Polygon(outline) if outline.is_convex())));
            if let Some(fast) = fast {
                n_taken.set(n_taken.get() + 1);
                // Both are within 10 nm a step.
                prop_assert!((fast.position - whole.position).norm() < 2e-8, "{fast:?} {whole:?}");
                prop_assert!((fast.angle - whole.angle).abs() < 1e-6, "{fast:?} {whole:?}");
            }
        });
        assert!(10 * n_taken.get() > 8 * n_all.get(), "{} of {}", n_taken.get(), n_all.get());
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
    fn the_series_are_the_functions() {
        for k in -300..=300 {
            let angle = 1e-3 * f64::from(k);
            let (sin, cos) = sin_cos(angle);
            assert!((sin - angle.sin()).abs() < 1e-16 && (cos - angle.cos()).abs() < 2e-16);
        }
    }
}
