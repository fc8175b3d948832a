//! The outline of a pushed object.

use crate::{Contact, Ellipse, PlanarError, Polygon};
use nalgebra::Vector2;
use std::f64::consts::TAU;

/// The outline of an object, in its body frame, in m.
///
/// Edge i of a polygon runs from vertex i to i + 1 and p runs from 0 to 1 along it. An ellipse is
/// one edge, p being the share of the arc length from the end of its +x axis, counter-clockwise.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// A simple polygon.
    Polygon(Polygon),
    /// An ellipse or disc about the origin.
    Ellipse(Ellipse),
}

impl Shape {
    /// A square about the origin, side in m; vertex 0 is the one at (+, +).
    ///
    /// # Errors
    /// `NotPositive` for a side that is not positive and finite.
    pub fn square(side: f64) -> Result<Self, PlanarError> {
        Self::rectangle(side, side)
    }

    /// A rectangle about the origin, extents along x and y in m; vertex 0 is the one at (+, +).
    ///
    /// # Errors
    /// `NotPositive` for an extent that is not positive and finite.
    pub fn rectangle(width: f64, height: f64) -> Result<Self, PlanarError> {
        for (name, value) in [("width", width), ("height", height)] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(PlanarError::NotPositive { name, value });
            }
        }
        let (x, y) = (0.5 * width, 0.5 * height);
        let corners = [(x, y), (-x, y), (-x, -y), (x, -y)];
        Polygon::new(corners.iter().map(|c| Vector2::new(c.0, c.1)).collect()).map(Self::Polygon)
    }

    /// Area, in m².
    pub fn area(&self) -> f64 {
        match self {
            Self::Polygon(polygon) => polygon.area(),
            Self::Ellipse(ellipse) => ellipse.area(),
        }
    }

    /// Length of the outline, in m.
    pub fn perimeter(&self) -> f64 {
        match self {
            Self::Polygon(polygon) => polygon.perimeter(),
            Self::Ellipse(ellipse) => ellipse.perimeter(),
        }
    }

    /// Centroid of the area, in m.
    pub fn centroid(&self) -> Vector2<f64> {
        match self {
            Self::Polygon(polygon) => polygon.centroid(),
            Self::Ellipse(_) => Vector2::zeros(),
        }
    }

    /// ∫|r − about|² dA, the polar second moment of area, in m⁴.
    pub fn second_moment(&self, about: &Vector2<f64>) -> f64 {
        match self {
            Self::Polygon(polygon) => polygon.second_moment(about),
            Self::Ellipse(ellipse) => ellipse.second_moment(about),
        }
    }

    /// ∫|r − about| dA, in m³.
    pub fn distance_integral(&self, about: &Vector2<f64>) -> f64 {
        match self {
            Self::Polygon(polygon) => polygon.distance_integral(about),
            Self::Ellipse(ellipse) => ellipse.distance_integral(about),
        }
    }

    /// Mean distance of the area's points from `about`, in m.
    ///
    /// About the centroid it is the characteristic length c of uniform pressure (eq. 2.21).
    pub fn mean_distance(&self, about: &Vector2<f64>) -> f64 {
        self.distance_integral(about) / self.area()
    }

    /// Whether `point` (m) lies inside or on the outline.
    pub fn contains(&self, point: &Vector2<f64>) -> bool {
        match self {
            Self::Polygon(polygon) => polygon.contains(point),
            Self::Ellipse(ellipse) => ellipse.contains(point),
        }
    }

    /// Number of edges: that of the polygon's vertices, or one for a smooth outline.
    pub fn n_edges(&self) -> usize {
        match self {
            Self::Polygon(polygon) => polygon.vertices().len(),
            Self::Ellipse(_) => 1,
        }
    }

    /// The outline's point at `p` ∈ [0, 1] along `edge` (counted modulo their number), in m.
    pub fn point_at(&self, edge: usize, p: f64) -> Vector2<f64> {
        match self {
            Self::Polygon(polygon) => {
                let vertices = polygon.vertices();
                let (i, n) = (edge % vertices.len(), vertices.len());
                vertices[i].lerp(&vertices[(i + 1) % n], p)
            }
            Self::Ellipse(ellipse) => {
                let length = p.rem_euclid(1.0) * ellipse.perimeter();
                ellipse.at_parameter(ellipse.parameter_at_length(length))
            }
        }
    }

    /// The unit normal that points into the object at `p` along `edge`.
    pub fn inward_normal_at(&self, edge: usize, p: f64) -> Vector2<f64> {
        match self {
            Self::Polygon(polygon) => polygon.sides()[edge % polygon.sides().len()].normal,
            Self::Ellipse(ellipse) => {
                let (a, b) = ellipse.semi_axes();
                let point = self.point_at(edge, p);
                -Vector2::new(point.x / (a * a), point.y / (b * b)).normalize()
            }
        }
    }

    /// Radius of the smallest circle about the origin that holds the outline, in m.
    pub fn bounding_radius(&self) -> f64 {
        match self {
            Self::Polygon(polygon) => {
                polygon.vertices().iter().map(|v| v.norm()).fold(0.0, f64::max)
            }
            Self::Ellipse(ellipse) => {
                let (a, b) = ellipse.semi_axes();
                a.max(b)
            }
        }
    }

    /// The outline as points (m) for drawing: a polygon's vertices, or `n` points of an ellipse.
    pub fn outline(&self, n: usize) -> Vec<Vector2<f64>> {
        match self {
            Self::Polygon(polygon) => polygon.vertices().to_vec(),
            Self::Ellipse(ellipse) => {
                (0..n).map(|k| ellipse.at_parameter(TAU * k as f64 / n as f64)).collect()
            }
        }
    }

    /// Where a round pusher touches, or comes nearest to, the outline.
    ///
    /// - `pusher_center_b`: its center in the body frame, in m; - `pusher_radius`: in m.
    ///
    /// A non-convex outline may be touched at several places at once: the nearest one is returned,
    /// [`Shape::contacts`] returns all.
    pub fn contact(&self, pusher_center_b: &Vector2<f64>, pusher_radius: f64) -> Contact {
        match self {
            Self::Polygon(polygon) => {
                Contact::with_polygon(polygon, pusher_center_b, pusher_radius)
            }
            Self::Ellipse(ellipse) => {
                Contact::with_ellipse(ellipse, pusher_center_b, pusher_radius)
            }
        }
    }

    /// All places that a round pusher touches at once: the nearest, then those that are nearest among
    /// their neighbors with a gap at most `reach` (m) larger.
    ///
    /// One for a convex outline, or for a pusher whose center is inside.
    pub fn contacts(
        &self,
        pusher_center_b: &Vector2<f64>,
        pusher_radius: f64,
        reach: f64,
    ) -> Vec<Contact> {
        let nearest = self.contact(pusher_center_b, pusher_radius);
        let mut all = vec![nearest];
        if let Self::Polygon(polygon) = self
            && nearest.gap > -pusher_radius
        {
            let center = pusher_center_b;
            all.extend(Contact::others(polygon, &nearest, center, pusher_radius, reach));
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::Shape;
    use crate::{Ellipse, MIT_NAMES, Pose, mit_object};
    use nalgebra::Vector2;

    fn shapes() -> Vec<Shape> {
        let mut shapes: Vec<_> = MIT_NAMES.iter().map(|n| mit_object(n).unwrap().shape).collect();
        shapes.push(Shape::rectangle(0.1, 0.02).unwrap());
        shapes.push(Shape::Ellipse(Ellipse::new(0.06, 0.02).unwrap()));
        shapes
    }

    /// Midpoint sums of 1, |r| and |r|² over n² cells, turned so that no edge runs along them.
    fn grid_sums(shape: &Shape, about: &Vector2<f64>, n: usize) -> [f64; 3] {
        let half = shape.bounding_radius();
        let turn = Pose::new(0.0, 0.0, 0.3);
        let cell = 2.0 * half / n as f64;
        let mut sums = [0.0; 3];
        for i in 0..n {
            for j in 0..n {
                let at = |k: usize| -half + (k as f64 + 0.5) * cell;
                let point = turn.rotate(&Vector2::new(at(i), at(j)));
                if shape.contains(&point) {
                    let r = (point - about).norm();
                    sums = [sums[0] + 1.0, sums[1] + r, sums[2] + r * r];
                }
            }
        }
        sums.map(|s| s * cell * cell)
    }

    #[test]
    fn closed_form_moments_of_every_shape_agree_with_a_grid() {
        for shape in shapes() {
            for about in [shape.centroid(), Vector2::new(0.013, -0.027)] {
                let [area, first, second] = grid_sums(&shape, &about, 1200);
                assert!((shape.area() / area - 1.0).abs() < 5e-4, "{shape:?}");
                assert!((shape.distance_integral(&about) / first - 1.0).abs() < 5e-4, "{shape:?}");
                assert!((shape.second_moment(&about) / second - 1.0).abs() < 5e-4, "{shape:?}");
            }
        }
    }

    #[test]
    fn outline_points_lie_on_the_outline_and_their_normal_points_inward() {
        for shape in shapes() {
            for edge in 0..shape.n_edges() {
                for p in [0.1, 0.5, 0.9] {
                    let (point, normal) =
                        (shape.point_at(edge, p), shape.inward_normal_at(edge, p));
                    assert!((normal.norm() - 1.0).abs() < 1e-12);
                    assert!(shape.contains(&(point + 1e-7 * normal)));
                    assert!(!shape.contains(&(point - 1e-7 * normal)));
                }
            }
        }
    }
}
