//! A straight push at the inside of one edge, without allocation.

use crate::runge_kutta::{Step, step};
use crate::{Ellipsoid, Pusher};
use nalgebra::Vector2;
use planar::{Pose, Shape, perpendicular};

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
/// The same steps and tolerance; no history is kept and nothing is allocated.
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

/// How the pusher moves; the state is the contact's place s along t, in m, and the turn φ, in rad.
struct Way<'a> {
    push: &'a EdgePush,
    edge: Edge,
    /// Its motion at the start, a unit vector in the axes of the edge.
    direction: Vector2<f64>,
    /// The pusher's center along n, in m.
    center_x: f64,
    friction: f64,
}

/// Which way the pusher slides: to the left, to the right, or it sticks.
#[derive(Clone, Copy, PartialEq)]
enum Slides {
    Left,
    Right,
    Not,
}

/// What the contact does.
#[derive(Clone, Copy)]
struct Look {
    slides: Slides,
    /// By how much the force that would stick is beyond the left and the right edge of the friction
    /// cone.
    beyond: [f64; 2],
    /// Of the state, at unit speed of the pusher.
    slope: Vector2<f64>,
}

/// The pusher left the edge.
struct Left;

/// Error of a step, in m.
const TOLERANCE: f64 = 1e-8;
/// Longest travel of the pusher in a step, in m.
const MAX_TRAVEL: f64 = 5e-3;
/// Gap below which pusher and object touch, in m.
const TOUCH: f64 = 1e-9;
/// Travel within which a change between sticking and sliding is located, in m.
const SWITCH: f64 = 1e-8;
/// Most steps, and most looks for a change.
const MOST_STEPS: usize = 64;

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

    /// The motion of B, its end seen from its start, while a pusher's center goes from `start_b` by
    /// `distance` (both in m) along the unit vector `direction_b`.
    ///
    /// None where the pusher does not stay inside of `edge` or does not press: [`crate::push_along`]
    /// takes all that.
    pub fn push(
        &self,
        pusher: &Pusher,
        edge: usize,
        start_b: &Vector2<f64>,
        direction_b: &Vector2<f64>,
        distance: f64,
    ) -> Option<Pose> {
        let edge = *self.edges.get(edge)?;
        let left_b = perpendicular(&edge.normal_b);
        let in_edge = |v: &Vector2<f64>| Vector2::new(edge.normal_b.dot(v), left_b.dot(v));
        let (direction, start) = (in_edge(direction_b), in_edge(&(start_b - self.center_b)));
        let center_x = edge.x - pusher.radius;
        let way = Way { push: self, edge, direction, center_x, friction: pusher.friction };
        // An object that overlaps the pusher is moved out of it along the normal.
        let gap = center_x - start.x;
        let free = if gap > TOUCH { gap / direction.x } else { 0.0 };
        if !(free >= 0.0 && free < distance) {
            return None;
        }
        let first = Vector2::new(start.y + free * direction.y, 0.0);
        let last = way.along(first, distance - free)?;
        // Where the pusher's center is tells where the object is.
        let (sin, cos) = sin_cos(last.y);
        let center = start + distance * direction;
        let held = Vector2::new(cos * center_x - sin * last.x, sin * center_x + cos * last.x);
        let moved = center - held;
        let position = moved.x * edge.normal_b + moved.y * left_b;
        let turned = Pose::new(0.0, 0.0, last.y).rotate(&self.center_b);
        Some(Pose { position: position + self.center_b - turned, angle: last.y })
    }
}

impl Way<'_> {
    /// The state after a way; none if the pusher leaves the edge.
    fn along(&self, first: Vector2<f64>, way: f64) -> Option<Vector2<f64>> {
        let (mut state, mut left, mut longest) = (first, way, MAX_TRAVEL);
        for _ in 0..MOST_STEPS {
            let here = self.look(&state)?;
            let mut h = left.min(longest);
            let Step { mut end, error } = self.step(h, &state, &here)?;
            let arm = Vector2::new(self.center_x, end.x).norm();
            if error.x.abs() + arm * error.y.abs() > TOLERANCE {
                longest = 0.5 * h;
                continue;
            }
            let there = self.look(&end)?;
            if there.slides != here.slides {
                (h, end) = self.switch(h, &state, &here, &there)?;
            }
            if h >= left {
                return Some(end);
            }
            (state, left) = (end, left - h);
        }
        None
    }

    #[inline]
    fn step(&self, h: f64, state: &Vector2<f64>, here: &Look) -> Option<Step<2>> {
        let slope =
            |_: f64, state: &Vector2<f64>| self.look(state).map(|look| look.slope).ok_or(Left);
        step(0.0, state, &here.slope, h, slope).ok()
    }

    /// The way and the state just after a change between sticking and sliding, by secants from both
    /// sides; none for a change from side to side at once.
    fn switch(
        &self,
        h: f64,
        state: &Vector2<f64>,
        here: &Look,
        there: &Look,
    ) -> Option<(f64, Vector2<f64>)> {
        let side = match (here.slides, there.slides) {
            (Slides::Not, Slides::Left) | (Slides::Left, Slides::Not) => 0,
            (Slides::Not, Slides::Right) | (Slides::Right, Slides::Not) => 1,
            _ => return None,
        };
        let (mut low, mut high) = ((0.0, here.beyond[side]), (h, there.beyond[side]));
        let mut end = self.step(h, state, here)?.end;
        for k in 0..MOST_STEPS {
            if high.0 - low.0 <= SWITCH {
                return Some((high.0, end));
            }
            let root = low.0 + (high.0 - low.0) * low.1 / (low.1 - high.1);
            // A little after and a little before in turn, to have it between them.
            let off = if k.is_multiple_of(2) { 0.4 * SWITCH } else { -0.4 * SWITCH };
            let at = (root + off).clamp(low.0 + 0.1 * SWITCH, high.0 - 0.1 * SWITCH);
            let tried = self.step(at, state, here)?.end;
            let look = self.look(&tried)?;
            if look.slides == here.slides {
                low = (at, look.beyond[side]);
            } else {
                (high, end) = ((at, look.beyond[side]), tried);
            }
        }
        None
    }

    /// What the contact does; none where the pusher is beside the edge or does not press.
    #[inline]
    fn look(&self, state: &Vector2<f64>) -> Option<Look> {
        let (s, x, c2) = (state.x, self.edge.x, self.push.length_squared);
        if !(s > self.edge.ends[0] && s < self.edge.ends[1]) {
            return None;
        }
        let (sin, cos) = sin_cos(state.y);
        let v_n = cos * self.direction.x + sin * self.direction.y;
        let v_t = cos * self.direction.y - sin * self.direction.x;
        if v_n <= 0.0 {
            return None;
        }
        let size = 1.0 / (c2 + x * x + s * s);
        let f_n = ((c2 + x * x) * v_n + x * s * v_t) * size;
        let f_t = ((c2 + s * s) * v_t + x * s * v_n) * size;
        let beyond = [f_t - self.friction * f_n, -f_t - self.friction * f_n];
        let (slides, f_t, turn) = if f_t.abs() <= self.friction * f_n {
            (Slides::Not, f_t, (x * v_t - s * v_n) * size)
        } else {
            let (slides, slope) = if f_t > 0.0 {
                (Slides::Left, self.friction)
            } else {
                (Slides::Right, -self.friction)
            };
            let f_n = c2 * v_n / (c2 + s * s - slope * x * s);
            (slides, slope * f_n, (slope * x - s) * f_n / c2)
        };
        let slope = Vector2::new(v_t - f_t - turn * self.center_x, turn);
        Some(Look { slides, beyond, slope })
    }
}

/// Sine and cosine, to rounding by their series for the small turns of a step.
#[inline]
fn sin_cos(angle: f64) -> (f64, f64) {
    if angle.abs() > 0.3 {
        return angle.sin_cos();
    }
    let x = angle * angle;
    let sin =
        1.0 - x / 6.0 * (1.0 - x / 20.0 * (1.0 - x / 42.0 * (1.0 - x / 72.0 * (1.0 - x / 110.0))));
    let cos = 1.0 - x / 30.0 * (1.0 - x / 56.0 * (1.0 - x / 90.0 * (1.0 - x / 132.0)));
    (angle * sin, 1.0 - x / 2.0 * (1.0 - x / 12.0 * cos))
}

#[cfg(test)]
mod tests {
    use super::{EdgePush, sin_cos};
    use crate::{Ellipsoid, PathMotion, PathSettings, Pusher, Slider, StraightPath, push_along};
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
        let fast = EdgePush::new(shape, &surface, &pose_bs)
            .and_then(|fast| fast.push(&pusher, edge, &start, &direction, distance));
        (fast, whole)
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
    fn the_series_are_the_functions() {
        for k in -300..=300 {
            let angle = 1e-3 * f64::from(k);
            let (sin, cos) = sin_cos(angle);
            assert!((sin - angle.sin()).abs() < 1e-16 && (cos - angle.cos()).abs() < 2e-16);
        }
    }
}
