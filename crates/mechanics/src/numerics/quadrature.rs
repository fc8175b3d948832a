//! Adaptive quadrature over plane shapes, exact in kind at the kink of a center of rotation.

use crate::MechanicsError;
use nalgebra::{Vector2, Vector3};
use planar::{GAUSS_LEGENDRE, Shape, cross};
use std::f64::consts::FRAC_PI_2;

/// A shape cut into triangles: of the plane itself, or of the polar coordinates of an ellipse.
#[derive(Clone, Debug)]
pub(crate) struct Cells {
    triangles: Vec<[Vector2<f64>; 3]>,
    /// Semi-axes, where the triangles are in (s, ψ) with r = s (a cos ψ, b sin ψ).
    ellipse: Option<(f64, f64)>,
}

const MAX_CELLS: usize = 20_000;

impl Cells {
    pub(crate) fn new(shape: &Shape) -> Self {
        match shape {
            Shape::Polygon(polygon) => Self { triangles: polygon.triangles(), ellipse: None },
            Shape::Ellipse(ellipse) => {
                let corner = |s: f64, k: u32| Vector2::new(s, FRAC_PI_2 * f64::from(k));
                let sector = |k: u32| {
                    [
                        [corner(0.0, k), corner(1.0, k), corner(1.0, k + 1)],
                        [corner(0.0, k), corner(1.0, k + 1), corner(0.0, k + 1)],
                    ]
                };
                let triangles = (0..4).flat_map(sector).collect();
                Self { triangles, ellipse: Some(ellipse.semi_axes()) }
            }
        }
    }

    /// ∫ f dA, with the sum of the local error estimates at most `tolerance`.
    ///
    /// f may have a conical kink (or a jump of direction) at `kink`: triangles that hold that point
    /// are cut there, and polar coordinates about it make f smooth in each part.
    pub(crate) fn integrate(
        &self,
        kink: Option<&Vector2<f64>>,
        tolerance: f64,
        f: &impl Fn(&Vector2<f64>) -> Result<Vector3<f64>, MechanicsError>,
    ) -> Result<Vector3<f64>, MechanicsError> {
        let kink = kink.map(|point| self.parameters(point));
        let pieces = self.triangles.iter().flat_map(|triangle| cut(triangle, kink.as_ref()));
        let mut active = Vec::new();
        for corners in pieces {
            active.push(Cell { corners, value: self.rule(&corners, f)? });
        }
        let mut done = (Vector3::zeros(), 0.0);
        let mut cells = active.len();
        while !active.is_empty() {
            let share = 0.5 * tolerance / cells.max(64) as f64;
            let mut next = Vec::new();
            for cell in active {
                let children = self.children(&cell, f)?;
                let sum: Vector3<f64> = children.iter().map(|child| child.value).sum();
                let error = (sum - cell.value).norm();
                if error <= share {
                    done = (done.0 + sum, done.1 + error);
                } else {
                    next.extend(children);
                }
            }
            cells += next.len();
            if cells > MAX_CELLS {
                let (what, iterations) = ("quadrature of the traction", cells);
                let residual = tolerance * next.len() as f64;
                return Err(MechanicsError::NotConverged { what, iterations, residual, tolerance });
            }
            active = next;
        }
        Ok(done.0)
    }

    /// Halves the longest side; a kink stays the first corner of the parts that hold it.
    fn children(
        &self,
        cell: &Cell,
        f: &impl Fn(&Vector2<f64>) -> Result<Vector3<f64>, MechanicsError>,
    ) -> Result<[Cell; 2], MechanicsError> {
        let [a, b, c] = cell.corners;
        let (ab, bc, ca) = ((b - a).norm(), (c - b).norm(), (a - c).norm());
        let halves = if bc >= ab && bc >= ca {
            let m = 0.5 * (b + c);
            [[a, b, m], [a, m, c]]
        } else if ab >= ca {
            let m = 0.5 * (a + b);
            [[a, m, c], [m, b, c]]
        } else {
            let m = 0.5 * (c + a);
            [[a, b, m], [b, c, m]]
        };
        let child = |corners| Ok(Cell { corners, value: self.rule(&corners, f)? });
        Ok([child(halves[0])?, child(halves[1])?])
    }

    /// 64 Gauss points in coordinates that collapse at the first corner.
    fn rule(
        &self,
        corners: &[Vector2<f64>; 3],
        f: &impl Fn(&Vector2<f64>) -> Result<Vector3<f64>, MechanicsError>,
    ) -> Result<Vector3<f64>, MechanicsError> {
        let [a, b, c] = corners;
        let twice_area = cross(&(b - a), &(c - a)).abs();
        let mut sum = Vector3::zeros();
        for (s, weight_s) in gauss_points() {
            for (u, weight_u) in gauss_points() {
                let q = a + s * ((b - a) + u * (c - b));
                let (point, stretch) = self.place(&q);
                sum += (weight_s * weight_u * s * twice_area * stretch) * f(&point)?;
            }
        }
        Ok(sum)
    }

    /// Where the parameters q are in the plane, and the area there for a unit area of parameters.
    fn place(&self, q: &Vector2<f64>) -> (Vector2<f64>, f64) {
        match self.ellipse {
            None => (*q, 1.0),
            Some((a, b)) => {
                let (sin, cos) = q.y.sin_cos();
                (Vector2::new(a * q.x * cos, b * q.x * sin), a * b * q.x)
            }
        }
    }

    fn parameters(&self, point: &Vector2<f64>) -> Vector2<f64> {
        match self.ellipse {
            None => *point,
            Some((a, b)) => {
                let (x, y) = (point.x / a, point.y / b);
                Vector2::new(x.hypot(y), y.atan2(x).rem_euclid(4.0 * FRAC_PI_2))
            }
        }
    }
}

struct Cell {
    corners: [Vector2<f64>; 3],
    value: Vector3<f64>,
}

/// The triangle itself, or its parts that meet at `kink` with that corner first.
fn cut(triangle: &[Vector2<f64>; 3], kink: Option<&Vector2<f64>>) -> Vec<[Vector2<f64>; 3]> {
    let [a, b, c] = *triangle;
    let twice_area = cross(&(b - a), &(c - a)).abs();
    let whole = vec![*triangle];
    let Some(&p) = kink else { return whole };
    let parts =
        [(a, b), (b, c), (c, a)].map(|(from, to)| (from, to, cross(&(from - p), &(to - p))));
    let sense = cross(&(b - a), &(c - a)).signum();
    if parts.iter().any(|(_, _, area)| sense * area < -1e-12 * twice_area) {
        return whole;
    }
    let wide = parts.into_iter().filter(|(_, _, area)| sense * area > 1e-12 * twice_area);
    wide.map(|(from, to, _)| [p, from, to]).collect()
}

/// The eight Gauss–Legendre points and weights on [0, 1].
pub(crate) fn gauss_points() -> [(f64, f64); 8] {
    std::array::from_fn(|k| {
        let (node, weight) = GAUSS_LEGENDRE[k / 2];
        let node = if k % 2 == 0 { -node } else { node };
        (0.5 * (1.0 + node), 0.5 * weight)
    })
}

#[cfg(test)]
mod tests {
    use super::Cells;
    use nalgebra::{Vector2, Vector3};
    use planar::{MIT_NAMES, mit_object};

    #[test]
    fn areas_and_distances_of_every_shape_are_those_of_the_closed_forms() {
        for name in MIT_NAMES {
            let shape = mit_object(name).unwrap().shape;
            let cells = Cells::new(&shape);
            let size = shape.area() * shape.bounding_radius();
            for about in [shape.centroid(), Vector2::new(0.011, -0.03), Vector2::new(0.07, 0.02)] {
                let f = |r: &Vector2<f64>| Ok(Vector3::new(1.0, (r - about).norm(), r.x));
                let sum = cells.integrate(Some(&about), 1e-11 * size, &f).unwrap();
                assert!((sum.x / shape.area() - 1.0).abs() < 1e-11, "{name}");
                let exact = shape.distance_integral(&about);
                assert!((sum.y - exact).abs() < 1e-11 * size, "{name} {}", sum.y / exact - 1.0);
                assert!((sum.z - shape.area() * shape.centroid().x).abs() < 1e-11 * size);
            }
        }
    }
}
