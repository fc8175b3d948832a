//! Friction loads of uniform pressure, in closed form on polygons.

use crate::quadrature::gauss_points;
use nalgebra::{Vector2, Vector3};
use planar::{Ellipse, Shape, cross, perpendicular};
use std::f64::consts::{PI, TAU};

/// Uniform traction over a shape, with Gauss points for motions that are nearly translations.
#[derive(Clone, Debug)]
pub(crate) struct UniformPatch {
    outline: Outline,
    traction: f64,
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

impl UniformPatch {
    pub(crate) fn new(shape: &Shape, f_max: f64) -> Self {
        let traction = f_max / shape.area();
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
        let points = areas.into_iter().map(|(r, area)| (r, traction * area)).collect();
        // Beyond four radii the velocity is smooth enough for the points, and the closed form would
        // start to lose digits to cancellation.
        let far = 4.0 * (shape.bounding_radius() + center.norm());
        Self { outline, traction, center, far, points }
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
            Outline::Edges(edges) => edge_integrals(edges, &pivot),
            Outline::Ellipse(ellipse) => ellipse_integrals(ellipse, &pivot),
        };
        let signed = self.traction.copysign(angular);
        let force = signed * perpendicular(&directions);
        let moment = signed * distance + cross(&pivot, &force);
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

/// The same two integrals over an ellipse, as line integrals ½ ∮ ρ̂ (ρ × dρ) and ⅓ ∮ |ρ| (ρ × dρ).
fn ellipse_integrals(ellipse: &Ellipse, pivot: &Vector2<f64>) -> (Vector2<f64>, f64) {
    let (a, b) = ellipse.semi_axes();
    let integrand = |psi: f64| {
        let (sin, cos) = psi.sin_cos();
        let rho = Vector2::new(a * cos, b * sin) - pivot;
        let swept = cross(&rho, &Vector2::new(-a * sin, b * cos));
        let length = rho.norm();
        if length == 0.0 {
            return Vector3::zeros();
        }
        let direction = 0.5 * swept / length * rho;
        Vector3::new(direction.x, direction.y, swept * length / 3.0)
    };
    // The integrand bends most where the outline passes the pivot, so intervals start there.
    let start = ellipse.nearest_parameter(pivot);
    let scale = a * b * Vector3::new(1.0, 1.0, a.max(b)).norm();
    let quarters = (0..4).map(|k| {
        let from = start + 0.5 * PI * f64::from(k);
        adaptive(&integrand, from, 0.5 * PI, 1e-14 * scale, 48)
    });
    let sum: Vector3<f64> = quarters.sum();
    (sum.xy(), sum.z)
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
