//! Friction loads of uniform and quadratic tractions: in closed form, or as integrals along outlines.

use crate::numerics::quadrature::gauss_points;
use nalgebra::{Vector2, Vector3};
use planar::{Ellipse, Shape, cross, perpendicular};
use std::f64::consts::{PI, TAU};

/// A traction c₀ + c₁ x + c₂ y + c₃ |r|² over a plane shape, in N/m² at r in m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuadraticTraction(pub [f64; 4]);

impl QuadraticTraction {
    /// The traction at a point.
    pub fn at(&self, r: &Vector2<f64>) -> f64 {
        let [constant, x, y, squared] = self.0;
        constant + x * r.x + y * r.y + squared * r.norm_squared()
    }

    /// Where in `shape` the traction is lowest, in m (of a curved outline, on 720 points).
    pub(crate) fn lowest(&self, shape: &Shape) -> Vector2<f64> {
        let [_, x, y, squared] = self.0;
        let inner = Vector2::new(x, y) / (-2.0 * squared);
        let mut places = shape.outline(720);
        if let Shape::Polygon(polygon) = shape {
            // Along an edge it is lowest at an end or at the foot of the inner extremum.
            places.extend(polygon.edges().map(|(a, b)| {
                let share = (inner - a).dot(&(b - a)) / (b - a).norm_squared();
                a + share.clamp(0.0, 1.0) * (b - a)
            }));
        }
        if shape.contains(&inner) {
            places.push(inner);
        }
        let finite = places.into_iter().filter(|r| r.x.is_finite() && r.y.is_finite());
        finite.min_by(|a, b| self.at(a).total_cmp(&self.at(b))).unwrap_or_default()
    }

    fn is_uniform(&self) -> bool {
        self.0[1..].iter().all(|c| *c == 0.0)
    }

    /// ∫ (1, u) u p(c + u ρ) du over u from 0 to 1, for the ray ρ from c to the outline.
    fn along_ray(&self, pivot: &Vector2<f64>, rho: &Vector2<f64>) -> (f64, f64) {
        let [_, x, y, squared] = self.0;
        let start = self.at(pivot);
        let slope = Vector2::new(x, y).dot(rho) + 2.0 * squared * pivot.dot(rho);
        let bend = squared * rho.norm_squared();
        (start / 2.0 + slope / 3.0 + bend / 4.0, start / 3.0 + slope / 4.0 + bend / 5.0)
    }
}

/// A traction over a shape, with Gauss points for motions that are nearly translations.
#[derive(Clone, Debug)]
pub(crate) struct QuadraticPatch {
    outline: Outline,
    traction: QuadraticTraction,
    /// The total, in N.
    bears: f64,
    center: Vector2<f64>,
    far: f64,
    /// Place, and force that it bears, for smooth fields of velocity.
    points: Vec<(Vector2<f64>, f64)>,
}

#[derive(Clone, Debug)]
enum Outline {
    Edges(Vec<(Vector2<f64>, Vector2<f64>)>),
    Ellipse(Ellipse),
}

impl QuadraticPatch {
    pub(crate) fn new(shape: &Shape, traction: QuadraticTraction) -> Self {
        let center = shape.centroid();
        let (outline, areas) = match shape {
            Shape::Polygon(polygon) => {
                let edges: Vec<_> = polygon.edges().collect();
                let areas = edges.iter().flat_map(|(a, b)| triangle_points(&center, a, b));
                let areas: Vec<_> = areas.collect();
                (Outline::Edges(edges), areas)
            }
            Shape::Ellipse(ellipse) => (Outline::Ellipse(*ellipse), ellipse_points(ellipse)),
        };
        let points: Vec<_> =
            areas.into_iter().map(|(r, area)| (r, area * traction.at(&r))).collect();
        // Beyond four radii the velocity is smooth enough for the points, and the closed form would
        // start to lose digits to cancellation.
        let bears = points.iter().map(|(_, bears)| bears).sum();
        let far = 4.0 * (shape.bounding_radius() + center.norm());
        Self { outline, traction, bears, center, far, points }
    }

    /// What the whole patch bears, in N, and its center, in m.
    pub(crate) fn total(&self) -> (f64, Vector2<f64>) {
        let total: f64 = self.points.iter().map(|(_, bears)| bears).sum();
        let moment: Vector2<f64> = self.points.iter().map(|(r, bears)| *bears * r).sum();
        (total, moment / total)
    }

    /// The load (Fx, Fy, M) of a nonzero motion (vx, vy, ω).
    pub(crate) fn load(&self, twist: &Vector3<f64>) -> Vector3<f64> {
        let (linear, angular) = (twist.xy(), twist.z);
        let at_center = linear + angular * perpendicular(&self.center);
        if at_center.norm() > self.far * angular.abs() {
            return self.smooth_load(&linear, angular);
        }
        let pivot = perpendicular(&linear) / angular;
        let (directions, distance) = match &self.outline {
            Outline::Edges(edges) if self.traction.is_uniform() => {
                let (directions, distance) = edge_integrals(edges, &pivot);
                (self.traction.0[0] * directions, self.traction.0[0] * distance)
            }
            Outline::Edges(edges) => self.along_edges(edges, &pivot),
            Outline::Ellipse(ellipse) => self.along_ellipse(ellipse, &pivot),
        };
        let sense = 1.0_f64.copysign(angular);
        let force = sense * perpendicular(&directions);
        let moment = sense * distance + cross(&pivot, &force);
        Vector3::new(force.x, force.y, moment)
    }

    fn smooth_load(&self, linear: &Vector2<f64>, angular: f64) -> Vector3<f64> {
        let mut load = Vector3::zeros();
        for (r, bears) in &self.points {
            let velocity = linear + angular * perpendicular(r);
            let force = *bears / velocity.norm() * velocity;
            load += Vector3::new(force.x, force.y, cross(r, &force));
        }
        load
    }

    /// What the outline's step from r to r + dr adds to the two integrals of [`edge_integrals`] with
    /// the traction as weight: (ρ × dr) times ρ̂ ∫ u p du and times |ρ| ∫ u² p du, with ρ = r − c.
    fn swept(&self, pivot: &Vector2<f64>, rho: &Vector2<f64>, step: &Vector2<f64>) -> Vector3<f64> {
        let length = rho.norm();
        if length == 0.0 {
            return Vector3::zeros();
        }
        let (first, second) = self.traction.along_ray(pivot, rho);
        let swept = cross(rho, step);
        let direction = first * swept / length * rho;
        Vector3::new(direction.x, direction.y, second * swept * length)
    }

    fn along_edges(
        &self,
        edges: &[(Vector2<f64>, Vector2<f64>)],
        pivot: &Vector2<f64>,
    ) -> (Vector2<f64>, f64) {
        let tolerance = 1e-14 * self.bears / edges.len() as f64;
        let mut sum = Vector3::zeros();
        for (a, b) in edges {
            let step = b - a;
            let integrand = |s: f64| self.swept(pivot, &(a + s * step - pivot), &step);
            // The integrand bends most at the foot of the pivot, so intervals start there.
            let foot = (pivot - a).dot(&step) / step.norm_squared();
            let split = if foot > 0.0 && foot < 1.0 { foot } else { 0.5 };
            sum += adaptive(&integrand, 0.0, split, tolerance, 48);
            sum += adaptive(&integrand, split, 1.0 - split, tolerance, 48);
        }
        (sum.xy(), sum.z)
    }

    fn along_ellipse(&self, ellipse: &Ellipse, pivot: &Vector2<f64>) -> (Vector2<f64>, f64) {
        let (a, b) = ellipse.semi_axes();
        let integrand = |psi: f64| {
            let (sin, cos) = psi.sin_cos();
            let rho = Vector2::new(a * cos, b * sin) - pivot;
            self.swept(pivot, &rho, &Vector2::new(-a * sin, b * cos))
        };
        // The integrand bends most where the outline passes the pivot, so intervals start there.
        let start = ellipse.nearest_parameter(pivot);
        let quarters = (0..4).map(|k| {
            let from = start + 0.5 * PI * f64::from(k);
            adaptive(&integrand, from, 0.5 * PI, 1e-14 * self.bears, 48)
        });
        let sum: Vector3<f64> = quarters.sum();
        (sum.xy(), sum.z)
    }
}

/// ∫ (r − c)/|r − c| dA and ∫ |r − c| dA over a polygon, as a sum over its edges.
///
/// With the edge at the signed distance d from c, e along it and n away from c, the triangle of c
/// and the edge adds ½ d (e [ρ] + n d [asinh(s/|d|)]) and d/6 [s ρ + d² asinh(s/|d|)], where
/// s is measured along the edge from the foot of c, ρ² = s² + d², and [·] is end minus start.
fn edge_integrals(
    edges: &[(Vector2<f64>, Vector2<f64>)],
    pivot: &Vector2<f64>,
) -> (Vector2<f64>, f64) {
    let mut directions = Vector2::zeros();
    let mut distance = 0.0;
    for (a, b) in edges {
        let (a, b) = (a - pivot, b - pivot);
        let length = (b - a).norm();
        let along = (b - a) / length;
        let d = cross(&a, &along);
        if d == 0.0 {
            continue;
        }
        let (start, end) = (a.dot(&along), b.dot(&along));
        let (near, far) = (a.norm(), b.norm());
        let angle = (end / d.abs()).asinh() - (start / d.abs()).asinh();
        directions += 0.5 * d * ((far - near) * along - d * angle * perpendicular(&along));
        distance += d / 6.0 * (end * far - start * near + d * d * angle);
    }
    (directions, distance)
}

/// ∫ f by halving the interval until both halves agree with the whole.
fn adaptive(
    f: &impl Fn(f64) -> Vector3<f64>,
    from: f64,
    width: f64,
    tolerance: f64,
    depth: u32,
) -> Vector3<f64> {
    let rule = |from: f64, width: f64| -> Vector3<f64> {
        gauss_points().iter().map(|(s, weight)| weight * width * f(from + s * width)).sum()
    };
    let half = 0.5 * width;
    let (left, right) = (rule(from, half), rule(from + half, half));
    if depth == 0 || (left + right - rule(from, width)).norm() <= tolerance {
        return left + right;
    }
    adaptive(f, from, half, tolerance, depth - 1)
        + adaptive(f, from + half, half, tolerance, depth - 1)
}

/// Points and signed areas for the triangle of the center and an edge.
fn triangle_points(
    center: &Vector2<f64>,
    a: &Vector2<f64>,
    b: &Vector2<f64>,
) -> Vec<(Vector2<f64>, f64)> {
    let twice_area = cross(&(a - center), &(b - center));
    let mut points = Vec::with_capacity(64);
    for (s, weight_s) in gauss_points() {
        for (u, weight_u) in gauss_points() {
            let r = center + s * (a + u * (b - a) - center);
            points.push((r, weight_s * weight_u * s * twice_area));
        }
    }
    points
}

fn ellipse_points(ellipse: &Ellipse) -> Vec<(Vector2<f64>, f64)> {
    const ANGLES: u32 = 48;
    let (a, b) = ellipse.semi_axes();
    let step = TAU / f64::from(ANGLES);
    let mut points = Vec::with_capacity(8 * ANGLES as usize);
    for (s, weight) in gauss_points() {
        for k in 0..ANGLES {
            let r = s * ellipse.at_parameter(step * f64::from(k));
            points.push((r, weight * s * step * a * b));
        }
    }
    points
}
