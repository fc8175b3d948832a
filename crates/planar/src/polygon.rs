//! Simple polygons, convex or not.

use crate::triangulation::triangulation;
use crate::{PlanarError, cross, perpendicular};
use nalgebra::Vector2;

/// A simple polygon, vertices counter-clockwise, in m.
#[derive(Clone, Debug, PartialEq)]
pub struct Polygon {
    vertices: Vec<Vector2<f64>>,
    /// What contacts ask of each edge, computed once.
    sides: Vec<Side>,
    is_convex: bool,
}

/// An edge of a polygon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Side {
    pub(crate) from: Vector2<f64>,
    pub(crate) to: Vector2<f64>,
    /// From its start to its end, in m.
    pub(crate) along: Vector2<f64>,
    pub(crate) length_squared: f64,
    /// Unit normal into the polygon.
    pub(crate) normal: Vector2<f64>,
}

impl Polygon {
    /// A polygon from its vertices (m), counter-clockwise; edge i runs from vertex i to i + 1.
    ///
    /// # Errors
    /// Fewer than three vertices, coordinates that are not finite, edges without length, clockwise
    /// order, no area, or edges that cross or touch. The check costs O(n²).
    pub fn new(vertices: Vec<Vector2<f64>>) -> Result<Self, PlanarError> {
        if vertices.len() < 3 {
            return Err(PlanarError::TooFewVertices { count: vertices.len() });
        }
        if let Some((index, v)) = vertices.iter().enumerate().find(|(_, v)| !is_finite(v)) {
            return Err(PlanarError::NotFinite { index, x: v.x, y: v.y });
        }
        let next = vertices.iter().cycle().skip(1);
        let sides = vertices.iter().zip(next).map(|(from, to)| Side::between(*from, *to)).collect();
        let is_convex = is_convex(&vertices);
        let polygon = Self { vertices, sides, is_convex };
        polygon.check_edges()?;
        polygon.check_area()?;
        polygon.check_simple()?;
        Ok(polygon)
    }

    /// The vertices, counter-clockwise, in m.
    pub fn vertices(&self) -> &[Vector2<f64>] {
        &self.vertices
    }

    /// The edges as pairs of their end points, in m; edge i runs from vertex i to i + 1.
    pub fn edges(&self) -> impl Iterator<Item = (Vector2<f64>, Vector2<f64>)> + '_ {
        let next = self.vertices.iter().cycle().skip(1);
        self.vertices.iter().zip(next).map(|(a, b)| (*a, *b))
    }

    /// Area, in m².
    pub fn area(&self) -> f64 {
        0.5 * self.edges().map(|(a, b)| cross(&a, &b)).sum::<f64>()
    }

    /// Length of the outline, in m.
    pub fn perimeter(&self) -> f64 {
        self.edges().map(|(a, b)| (b - a).norm()).sum()
    }

    /// Centroid of the area, in m.
    pub fn centroid(&self) -> Vector2<f64> {
        let origin = self.vertices[0];
        let moment: Vector2<f64> = self
            .edges()
            .map(|(a, b)| (a - origin, b - origin))
            .map(|(a, b)| cross(&a, &b) * (a + b))
            .sum();
        origin + moment / (6.0 * self.area())
    }

    /// ∫|r − about|² dA, the polar second moment of area, in m⁴.
    pub fn second_moment(&self, about: &Vector2<f64>) -> f64 {
        let terms = self
            .edges()
            .map(|(a, b)| (a - about, b - about))
            .map(|(a, b)| cross(&a, &b) * (a.norm_squared() + a.dot(&b) + b.norm_squared()));
        terms.sum::<f64>() / 12.0
    }

    /// ∫|r − about| dA, in m³, in closed form.
    ///
    /// Each edge spans a triangle with `about`; with the edge's distance h and its end points at
    /// the signed distances s along it, the triangle gives h³/3 ∫ sec³φ dφ = h/6 (s R + h² asinh(s/h))
    /// between its ends, R² = h² + s².
    pub fn distance_integral(&self, about: &Vector2<f64>) -> f64 {
        self.edges().map(|(a, b)| triangle_distance_integral(&(a - about), &(b - about))).sum()
    }

    /// Triangles that make up the area, each counter-clockwise and of positive area, in m.
    ///
    /// Ears are cut off, the roundest first; costs O(n²) and more where ears are hidden.
    pub fn triangles(&self) -> Vec<[Vector2<f64>; 3]> {
        triangulation(&self.vertices)
    }

    /// Whether `point` (m) lies inside or on the outline.
    pub fn contains(&self, point: &Vector2<f64>) -> bool {
        let mut inside = false;
        for Side { from, to, along, .. } in &self.sides {
            let side = cross(along, &(point - from));
            if side == 0.0 && (point - from).dot(&(point - to)) <= 0.0 {
                return true;
            }
            if (from.y > point.y) != (to.y > point.y) && (side > 0.0) == (to.y > from.y) {
                inside = !inside;
            }
        }
        inside
    }

    /// The edges, each with what contacts ask of it.
    pub(crate) fn sides(&self) -> &[Side] {
        &self.sides
    }

    /// Whether every inner angle is below or at 180°.
    pub fn is_convex(&self) -> bool {
        self.is_convex
    }

    fn check_edges(&self) -> Result<(), PlanarError> {
        match self.edges().enumerate().find(|(_, (a, b))| a == b) {
            Some((edge, (a, _))) => Err(PlanarError::EdgeWithoutLength { edge, x: a.x, y: a.y }),
            None => Ok(()),
        }
    }

    fn check_area(&self) -> Result<(), PlanarError> {
        let origin = self.vertices[0];
        let signed = self.edges().map(|(a, b)| 0.5 * cross(&(a - origin), &(b - origin)));
        let (area, perimeter) = (signed.sum::<f64>(), self.perimeter());
        if area.abs() <= 1e-12 * perimeter * perimeter {
            return Err(PlanarError::NoArea { area, perimeter });
        }
        if area < 0.0 {
            return Err(PlanarError::Clockwise { area });
        }
        Ok(())
    }

    fn check_simple(&self) -> Result<(), PlanarError> {
        let edges: Vec<_> = self.edges().collect();
        let n = edges.len();
        for first in 0..n {
            for second in first + 1..n {
                let neighbors = second == first + 1 || (first == 0 && second == n - 1);
                if neighbors && !fold_back(&edges, first, second) {
                    continue;
                }
                if neighbors || segments_meet(&edges[first], &edges[second]) {
                    return Err(PlanarError::SelfIntersection { first, second });
                }
            }
        }
        Ok(())
    }
}

impl Side {
    fn between(from: Vector2<f64>, to: Vector2<f64>) -> Self {
        let along = to - from;
        let (length_squared, normal) = (along.norm_squared(), perpendicular(&along).normalize());
        Self { from, to, along, length_squared, normal }
    }
}

type Segment = (Vector2<f64>, Vector2<f64>);

fn is_convex(vertices: &[Vector2<f64>]) -> bool {
    let n = vertices.len();
    (0..n).all(|i| {
        let (a, b) = (vertices[i], vertices[(i + 1) % n]);
        cross(&(b - a), &(vertices[(i + 2) % n] - b)) >= 0.0
    })
}

fn is_finite(v: &Vector2<f64>) -> bool {
    v.x.is_finite() && v.y.is_finite()
}

/// Whether two neighboring edges lie on each other (an inner angle of zero).
fn fold_back(edges: &[Segment], first: usize, second: usize) -> bool {
    let (before, after) = if second == first + 1 { (first, second) } else { (second, first) };
    let (u, v) = (edges[before].1 - edges[before].0, edges[after].1 - edges[after].0);
    cross(&u, &v) == 0.0 && u.dot(&v) < 0.0
}

fn segments_meet(p: &Segment, q: &Segment) -> bool {
    let side = |s: &Segment, x: &Vector2<f64>| cross(&(s.1 - s.0), &(x - s.0));
    let (a, b) = (side(p, &q.0), side(p, &q.1));
    let (c, d) = (side(q, &p.0), side(q, &p.1));
    if a * b < 0.0 && c * d < 0.0 {
        return true;
    }
    let on =
        |s: &Segment, x: &Vector2<f64>, side: f64| side == 0.0 && (x - s.0).dot(&(x - s.1)) <= 0.0;
    on(p, &q.0, a) || on(p, &q.1, b) || on(q, &p.0, c) || on(q, &p.1, d)
}

/// ∫|r| dA over the triangle (0, a, b), negative if it runs clockwise, in m³.
fn triangle_distance_integral(a: &Vector2<f64>, b: &Vector2<f64>) -> f64 {
    let edge = b - a;
    let length = edge.norm();
    let distance = cross(a, b) / length;
    if distance == 0.0 {
        return 0.0;
    }
    let (from, to) = (a.dot(&edge) / length, b.dot(&edge) / length);
    let height = distance.abs();
    let primitive = |s: f64| s * s.hypot(height) + height * height * (s / height).asinh();
    distance / 6.0 * (primitive(to) - primitive(from))
}

#[cfg(test)]
mod tests {
    use super::Polygon;
    use crate::PlanarError;
    use nalgebra::Vector2;

    fn polygon(points: &[[f64; 2]]) -> Result<Polygon, PlanarError> {
        Polygon::new(points.iter().map(|p| Vector2::new(p[0], p[1])).collect())
    }

    fn l_shape() -> Polygon {
        let points = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]];
        polygon(&points).unwrap()
    }

    #[test]
    fn an_l_shape_has_the_area_and_centroid_of_its_two_rectangles() {
        let shape = l_shape();
        assert!((shape.area() - 4.0).abs() < 1e-15);
        let expected = Vector2::new((2.0 * 1.0 + 2.0 * 0.5) / 4.0, (2.0 * 0.5 + 2.0 * 2.0) / 4.0);
        assert!((shape.centroid() - expected).norm() < 1e-15);
        assert!(!shape.is_convex());
        assert!(
            shape.contains(&Vector2::new(0.5, 2.5)) && !shape.contains(&Vector2::new(1.5, 2.0))
        );
    }

    #[test]
    fn the_mean_distance_of_a_square_is_the_closed_form_of_the_thesis() {
        let a = 0.09;
        let h = a / 2.0;
        let square = polygon(&[[h, h], [-h, h], [-h, -h], [h, -h]]).unwrap();
        let c = square.distance_integral(&Vector2::zeros()) / square.area();
        let expected = a * (2.0_f64.sqrt() + (1.0 + 2.0_f64.sqrt()).ln()) / 6.0;
        assert!((c - expected).abs() < 1e-16);
        assert!((expected / a - 0.3826).abs() < 1e-4);
    }

    #[test]
    fn moments_agree_with_a_fine_grid_about_any_point() {
        let shape = l_shape();
        let n = 1000;
        let cell = (2.0 / n as f64, 3.0 / n as f64);
        for about in [Vector2::new(0.0, 0.0), Vector2::new(0.7, 0.4), Vector2::new(-1.0, 2.0)] {
            let (mut first, mut second) = (0.0, 0.0);
            for i in 0..n {
                for j in 0..n {
                    let r = Vector2::new((i as f64 + 0.5) * cell.0, (j as f64 + 0.5) * cell.1);
                    if shape.contains(&r) {
                        let d = (r - about).norm();
                        first += d * cell.0 * cell.1;
                        second += d * d * cell.0 * cell.1;
                    }
                }
            }
            assert!((shape.distance_integral(&about) / first - 1.0).abs() < 2e-3);
            assert!((shape.second_moment(&about) / second - 1.0).abs() < 2e-3);
        }
    }

    #[test]
    fn bad_outlines_are_refused_with_their_reason() {
        let few = polygon(&[[0.0, 0.0], [1.0, 0.0]]);
        assert_eq!(few, Err(PlanarError::TooFewVertices { count: 2 }));
        let twice = polygon(&[[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
        assert_eq!(twice, Err(PlanarError::EdgeWithoutLength { edge: 1, x: 1.0, y: 0.0 }));
        let clockwise = polygon(&[[0.0, 0.0], [0.0, 1.0], [1.0, 0.0]]);
        assert_eq!(clockwise, Err(PlanarError::Clockwise { area: -0.5 }));
        let flat = polygon(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]]);
        assert_eq!(flat, Err(PlanarError::NoArea { area: 0.0, perimeter: 4.0 }));
        let bow = polygon(&[[0.0, 0.0], [3.0, 0.0], [1.0, 2.0], [2.0, -1.0]]);
        assert!(matches!(bow, Err(PlanarError::SelfIntersection { .. })), "{bow:?}");
        let spike = polygon(&[[0.0, 0.0], [2.0, 0.0], [1.0, 0.0], [1.0, 1.0]]);
        assert!(matches!(spike, Err(PlanarError::SelfIntersection { .. })), "{spike:?}");
        let nan = polygon(&[[0.0, 0.0], [1.0, f64::NAN], [0.0, 1.0]]);
        assert!(matches!(nan, Err(PlanarError::NotFinite { index: 1, .. })));
    }
}
