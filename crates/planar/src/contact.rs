//! Contact of a round pusher with an outline.

use crate::polygon::Side;
use crate::{Ellipse, Polygon, perpendicular};
use nalgebra::Vector2;
use std::f64::consts::TAU;

/// Where a round pusher touches an outline, all in the body frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// The outline's point that is nearest to the pusher, in m.
    pub point: Vector2<f64>,
    /// Unit normal of the contact, into the object. At a vertex it points from the pusher's center.
    pub normal: Vector2<f64>,
    /// 0-based edge; at a vertex, of the two that meet, the one that faces the pusher more.
    pub edge: usize,
    /// Position along the edge, 0 to 1.
    pub p: f64,
    /// Distance between the pusher's surface and the outline, in m; negative if they overlap.
    pub gap: f64,
    /// Whether the pusher touches an edge or a vertex.
    pub feature: Feature,
}

/// What part of the outline is touched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feature {
    /// The inside of an edge, or a smooth outline.
    Edge,
    /// A vertex, whose normal depends on the pusher's position.
    Vertex,
}

/// More than rounding errors of distances, relative to distances and places.
const ROUNDING: f64 = 1e-12;

impl Contact {
    /// The contact's tangent: the inward normal turned by +90°, the way of decreasing p.
    pub fn tangent(&self) -> Vector2<f64> {
        perpendicular(&self.normal)
    }

    pub(crate) fn with_polygon(polygon: &Polygon, center: &Vector2<f64>, radius: f64) -> Self {
        Self::beside_convex(polygon, center, radius)
            .unwrap_or_else(|| Self::by_all_edges(polygon, center, radius))
    }

    fn by_all_edges(polygon: &Polygon, center: &Vector2<f64>, radius: f64) -> Self {
        // No edge is nearer than its line, and some edge is as near as the nearest vertex.
        let to_vertex = |vertex: &Vector2<f64>| (vertex - center).norm_squared();
        let vertex = polygon.vertices().iter().map(to_vertex).fold(f64::INFINITY, f64::min).sqrt();
        let reach = vertex + ROUNDING * (vertex + center.amax());
        let mut nearest = Self::with_edge(polygon, 0, center);
        for (edge, side) in polygon.sides().iter().enumerate().skip(1) {
            if side.normal.dot(&(center - side.from)).abs() > reach {
                continue;
            }
            let candidate = Self::with_edge(polygon, edge, center);
            if candidate.is_nearer_than(&nearest, center) {
                nearest = candidate;
            }
        }
        let distance = (nearest.point - center).norm();
        // On the way to the inside of the nearest edge there is no other one.
        let inside = match nearest.feature {
            Feature::Edge if distance > 0.0 => nearest.normal.dot(&(center - nearest.point)) > 0.0,
            _ => polygon.contains(center),
        };
        if inside {
            nearest.normal = polygon.sides()[nearest.edge].normal;
            nearest.feature = Feature::Edge;
        } else if nearest.feature == Feature::Vertex && distance > 0.0 {
            nearest.normal = (nearest.point - center) / distance;
        }
        nearest.gap = if inside { -distance } else { distance } - radius;
        nearest
    }

    /// The contact with a convex polygon of a center outside of it that faces the inside of an edge:
    /// the same as by all edges, in less time; none for other centers.
    fn beside_convex(polygon: &Polygon, center: &Vector2<f64>, radius: f64) -> Option<Self> {
        if !polygon.is_convex() {
            return None;
        }
        let (mut edge, mut farthest) = (0, 0.0);
        for (index, side) in polygon.sides().iter().enumerate() {
            let outward = side.normal.dot(&(side.from - center));
            if outward > farthest {
                (edge, farthest) = (index, outward);
            }
        }
        let nearest = Self::with_edge(polygon, edge, center);
        let is_inside_edge = nearest.p > 0.0 && nearest.p < 1.0;
        // By the point, as for any other center, so that the bits are the same.
        let gap = (nearest.point - center).norm() - radius;
        (farthest > 0.0 && is_inside_edge).then_some(Self { gap, ..nearest })
    }

    /// The other places of a polygon that are nearest to a center among their neighbors, and at most
    /// `reach` further away than `nearest`.
    pub(crate) fn others(
        polygon: &Polygon,
        nearest: &Self,
        center: &Vector2<f64>,
        radius: f64,
        reach: f64,
    ) -> impl Iterator<Item = Self> {
        let n = polygon.vertices().len();
        let limit = nearest.gap + radius + reach;
        (0..n).filter_map(move |edge| {
            let mut contact = Self::with_edge(polygon, edge, center);
            let outward = center - contact.point;
            let distance = outward.norm();
            // A vertex counts once, with the edge that it begins, and only if both edges end there.
            let is_nearest_around = match contact.feature {
                Feature::Edge => outward.dot(&contact.normal) < 0.0,
                Feature::Vertex => {
                    contact.p == 0.0
                        && Self::with_edge(polygon, (edge + n - 1) % n, center).p == 1.0
                }
            };
            if distance > limit || !is_nearest_around || contact.point == nearest.point {
                return None;
            }
            if contact.feature == Feature::Vertex {
                contact.normal = -outward / distance;
            }
            contact.gap = distance - radius;
            Some(contact)
        })
    }

    pub(crate) fn with_ellipse(ellipse: &Ellipse, center: &Vector2<f64>, radius: f64) -> Self {
        let psi = ellipse.nearest_parameter(center);
        let point = ellipse.at_parameter(psi);
        let (a, b) = ellipse.semi_axes();
        let distance = (point - center).norm();
        Self {
            point,
            normal: -Vector2::new(point.x / (a * a), point.y / (b * b)).normalize(),
            edge: 0,
            p: ellipse.arc_length(psi.rem_euclid(TAU)) / ellipse.perimeter(),
            gap: if ellipse.contains(center) { -distance } else { distance } - radius,
            feature: Feature::Edge,
        }
    }

    /// The nearest point of one edge, its normal that of the edge.
    fn with_edge(polygon: &Polygon, edge: usize, center: &Vector2<f64>) -> Self {
        let Side { from, to, along, length_squared, normal } = polygon.sides()[edge];
        let share = (center - from).dot(&along) / length_squared;
        let p = share.clamp(0.0, 1.0);
        let feature = if share == p { Feature::Edge } else { Feature::Vertex };
        let point = if p == 1.0 { to } else { from + p * along };
        Self { point, normal, edge, p, gap: 0.0, feature }
    }

    /// Nearer to the center or, at a shared vertex, on the edge that faces the center more.
    fn is_nearer_than(&self, other: &Self, center: &Vector2<f64>) -> bool {
        if self.point == other.point {
            let outward = center - self.point;
            return outward.dot(&self.normal) < outward.dot(&other.normal);
        }
        (self.point - center).norm_squared() < (other.point - center).norm_squared()
    }
}

#[cfg(test)]
mod tests {
    use super::{Contact, Feature};
    use crate::{Ellipse, Polygon, Shape, mit_object};
    use nalgebra::Vector2;
    use proptest::prelude::{prop_assert, proptest};

    const RADIUS: f64 = 0.00475;

    #[test]
    fn a_pusher_left_of_the_square_touches_edge_one() {
        let square = Shape::square(0.09).unwrap();
        let contact = square.contact(&Vector2::new(-0.05, 0.0225), RADIUS);
        assert_eq!((contact.edge, contact.feature), (1, Feature::Edge));
        assert_eq!(contact.normal, Vector2::new(1.0, 0.0));
        assert!((contact.point - Vector2::new(-0.045, 0.0225)).norm() < 1e-17);
        assert!((contact.p - 0.25).abs() < 1e-15);
        assert!((contact.gap - (0.005 - RADIUS)).abs() < 1e-17);
        assert_eq!(contact.tangent(), Vector2::new(0.0, 1.0));
    }

    #[test]
    fn at_a_vertex_the_normal_points_from_the_pusher_and_the_facing_edge_is_named() {
        let square = Shape::square(0.09).unwrap();
        let center = Vector2::new(-0.048, 0.046);
        let contact = square.contact(&center, RADIUS);
        assert_eq!(contact.feature, Feature::Vertex);
        assert_eq!((contact.edge, contact.p), (1, 0.0));
        assert!((contact.normal - Vector2::new(0.003, -0.001).normalize()).norm() < 1e-12);
        let above = square.contact(&Vector2::new(-0.046, 0.048), RADIUS);
        assert_eq!((above.edge, above.p), (0, 1.0));
    }

    #[test]
    fn a_center_inside_the_outline_gives_a_negative_gap_and_the_same_normal() {
        let square = Shape::square(0.09).unwrap();
        let contact = square.contact(&Vector2::new(-0.044, 0.01), RADIUS);
        assert!((contact.gap + 0.001 + RADIUS).abs() < 1e-16);
        assert_eq!(contact.normal, Vector2::new(1.0, 0.0));
    }

    #[test]
    fn a_notch_is_touched_on_its_nearer_wall() {
        let points = [[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [2.0, 1.0], [0.0, 3.0]];
        let notch = points.iter().map(|p| Vector2::new(p[0], p[1])).collect();
        let shape = Shape::Polygon(Polygon::new(notch).unwrap());
        let contact = shape.contact(&Vector2::new(2.2, 2.0), 0.1);
        assert_eq!((contact.edge, contact.feature), (2, Feature::Edge));
        assert!((contact.gap - (0.8 / 2.0_f64.sqrt() - 0.1)).abs() < 1e-12);
    }

    #[test]
    fn a_pusher_wedged_in_a_notch_touches_both_walls() {
        let points = [[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [2.0, 1.0], [0.0, 3.0]];
        let notch = points.iter().map(|p| Vector2::new(p[0], p[1])).collect();
        let shape = Shape::Polygon(Polygon::new(notch).unwrap());
        let center = Vector2::new(2.0, 1.0 + 0.3 * 2.0_f64.sqrt());
        let edges = |center, reach| -> Vec<usize> {
            shape.contacts(center, 0.3, reach).iter().map(|contact| contact.edge).collect()
        };
        let mut both = edges(&center, 1e-9);
        both.sort_unstable();
        assert_eq!(both, [2, 3]);
        for contact in shape.contacts(&center, 0.3, 1e-9) {
            assert!(contact.gap.abs() < 1e-15);
            assert!((contact.normal.y + 0.5_f64.sqrt()).abs() < 1e-15);
        }
        assert_eq!(edges(&(center + Vector2::new(0.01, 0.0)), 1e-9), [2]);
        // Between the two tips each of them is nearest among its neighbors.
        let above = shape.contacts(&Vector2::new(2.0, 6.0), 0.3, 1e-9);
        assert!(above.iter().all(|contact| contact.feature == Feature::Vertex) && above.len() == 2);
    }

    proptest! {
        #[test]
        fn the_contact_undoes_a_pusher_placed_on_any_edge(
            name in 0..10usize, edge in 0..6usize, p in 0.02..0.98f64, gap in 0.0..0.01f64,
        ) {
            let shape = mit_object(crate::MIT_NAMES[name]).unwrap().shape;
            let edge = edge % shape.n_edges();
            let (point, normal) = (shape.point_at(edge, p), shape.inward_normal_at(edge, p));
            let contact = shape.contact(&(point - (RADIUS + gap) * normal), RADIUS);
            prop_assert!((contact.gap - gap).abs() < 1e-12);
            prop_assert!((contact.p - p).abs() < 1e-9 && contact.edge == edge);
            prop_assert!((contact.point - point).norm() < 1e-10);
            prop_assert!((contact.normal - normal).norm() < 1e-8);
        }

        #[test]
        fn a_convex_outline_has_the_contact_that_all_its_edges_give(
            name in 0..10usize, x in -0.1..0.1f64, y in -0.1..0.1f64,
        ) {
            let Shape::Polygon(polygon) = mit_object(crate::MIT_NAMES[name]).unwrap().shape else {
                return Ok(());
            };
            let center = Vector2::new(x, y);
            if let Some(fast) = Contact::beside_convex(&polygon, &center, RADIUS) {
                let slow = Contact::by_all_edges(&polygon, &center, RADIUS);
                prop_assert!(fast == slow, "{fast:?} {slow:?}");
            }
        }

        #[test]
        fn no_point_of_the_outline_is_nearer_than_the_contact(
            x in -0.1..0.1f64, y in -0.1..0.1f64, p in 0.0..1.0f64, edge in 0..200usize,
        ) {
            let center = Vector2::new(x, y);
            for shape in [
                mit_object("butter").unwrap().shape,
                mit_object("tri3").unwrap().shape,
                Shape::Ellipse(Ellipse::new(0.05, 0.03).unwrap()),
            ] {
                let contact = shape.contact(&center, 0.0);
                prop_assert!((contact.normal.norm() - 1.0).abs() < 1e-12);
                let other = (shape.point_at(edge, p) - center).norm();
                prop_assert!(contact.gap.abs() <= other + 1e-12);
                prop_assert!((contact.gap < 0.0) == shape.contains(&center) || contact.gap == 0.0);
            }
        }
    }
}
