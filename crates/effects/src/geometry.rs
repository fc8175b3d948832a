//! What touches where.

use nalgebra::Vector2;
use planar::{Contact, Polygon, Shape, cross, perpendicular};

use crate::{EffectError, StepInput};

/// Gathered changes of the contact's geometry: effects add to it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Geometry {
    /// The pusher's radius over its nominal value, in m.
    pub radius_excess: f64,
    /// How far the force acts from the nearest point, along the edge towards larger p, in m.
    pub contact_shift: f64,
    /// Radius of the outline's corners, in m.
    pub corner_radius: f64,
}

/// The true outline and pusher of one step.
pub(crate) struct Outline<'a> {
    shape: &'a Shape,
    /// The outline moved inwards by the corner radius: a round pusher of that much larger radius
    /// touches it where it touches the rounded outline.
    core: Option<Shape>,
    radius: f64,
    geometry: Geometry,
}

impl<'a> Outline<'a> {
    pub(crate) fn new(step: &'a StepInput, geometry: Geometry) -> Result<Self, EffectError> {
        let shape = step.object.shape();
        let core = match shape {
            Shape::Polygon(polygon) if geometry.corner_radius != 0.0 => {
                Some(moved_inwards(polygon, geometry.corner_radius)?)
            }
            Shape::Polygon(_) | Shape::Ellipse(_) => None,
        };
        Ok(Self { shape, core, radius: step.pusher_radius + geometry.radius_excess, geometry })
    }

    /// Nearest point, normal and gap for a pusher's center in the outline's frame, in m.
    pub(crate) fn nearest(&self, center_o: &Vector2<f64>) -> Contact {
        let Some(core) = &self.core else {
            return self.shape.contact(center_o, self.radius);
        };
        let contact = core.contact(center_o, self.radius + self.geometry.corner_radius);
        Contact { point: contact.point - self.geometry.corner_radius * contact.normal, ..contact }
    }

    /// Where the force acts.
    pub(crate) fn acting_point(&self, contact: &Contact) -> Vector2<f64> {
        contact.point - self.geometry.contact_shift * perpendicular(&contact.normal)
    }
}

/// The polygon with every edge moved inwards by `distance`, in m.
fn moved_inwards(polygon: &Polygon, distance: f64) -> Result<Shape, EffectError> {
    let vertices = polygon.vertices();
    let n = vertices.len();
    let along = |i: usize| (vertices[(i + 1) % n] - vertices[i % n]).normalize();
    let moved = |i: usize| {
        let (before, after) = (along(i + n - 1), along(i));
        // Along both edges the corner moves by distance · tan(half the turn).
        let tangent = cross(&before, &after) / (1.0 + before.dot(&after));
        vertices[i] + distance * (perpendicular(&after) + tangent * after)
    };
    let shortest = polygon.edges().map(|(a, b)| (b - a).norm()).fold(f64::INFINITY, f64::min);
    let corners: Vec<_> = (0..n).map(moved).collect();
    let keeps = |i: usize| (corners[(i + 1) % n] - corners[i]).dot(&along(i)) > 0.0;
    let refused = EffectError::TooRound { radius: distance, shortest };
    if !(0..n).all(keeps) {
        return Err(refused);
    }
    Polygon::new(corners).map(Shape::Polygon).map_err(|_| refused)
}

#[cfg(test)]
mod tests {
    use super::moved_inwards;
    use crate::EffectError;
    use nalgebra::Vector2;
    use planar::{Polygon, Shape, mit_object};

    fn polygon(shape: Shape) -> Polygon {
        let Shape::Polygon(polygon) = shape else { panic!("a polygon") };
        polygon
    }

    #[test]
    fn every_edge_moves_by_the_same_distance() {
        for name in ["rect1", "tri2", "hex", "butter"] {
            let outer = polygon(mit_object(name).unwrap().shape);
            let inner = polygon(moved_inwards(&outer, 1e-3).unwrap());
            for ((a, b), (c, _)) in outer.edges().zip(inner.edges()) {
                let normal = planar::perpendicular(&(b - a).normalize());
                assert!((normal.dot(&(c - a)) - 1e-3).abs() < 1e-15, "{name}");
            }
        }
    }

    #[test]
    fn corners_larger_than_the_outline_are_refused() {
        let square = polygon(Shape::square(0.1).unwrap());
        let error = moved_inwards(&square, 0.06).unwrap_err();
        assert_eq!(error, EffectError::TooRound { radius: 0.06, shortest: 0.1 });
        assert!((moved_inwards(&square, 0.04).unwrap().area() - 4e-4).abs() < 1e-15);
        let point = Vector2::new(0.01, 0.01);
        assert!(
            (polygon(moved_inwards(&square, 0.04).unwrap()).vertices()[0] - point).norm() < 1e-15
        );
    }
}
