//! What touches where.

use nalgebra::Vector2;
use planar::{Contact, Polygon, Pose, Shape, cross, perpendicular};

use crate::{EffectError, MeasurementModel, StepInput};

/// Gathered changes of the contact's geometry: effects add to it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Geometry {
    /// The pusher's radius over its nominal value, in m. Below a point's, the outline is so much smaller.
    pub radius_excess: f64,
    /// How far the force acts from the nearest point, along the edge towards larger p, in m.
    pub contact_shift: f64,
    /// Radius of the outline's corners, in m.
    pub corner_radius: f64,
    /// How far the pusher still is from the object where a push is said to begin, in m.
    pub approach_gap: f64,
}

/// Outline and pusher as a model has them: as stated, but for what its effects change.
#[derive(Clone, Debug)]
pub struct TrueOutline {
    core: Shape,
    reach: Reach,
    /// The outline's frame in the tracked one, if they are not the same.
    pose_bo: Option<Pose>,
    /// Place of the pusher beside where the robot tells it, in m, axes of W.
    robot_w: Vector2<f64>,
    latency: f64,
}

impl TrueOutline {
    /// Just as stated.
    ///
    /// - `pusher_radius`: in m.
    pub fn stated(shape: &Shape, pusher_radius: f64) -> Self {
        let reach = Reach { pusher_radius, inwards: 0.0 };
        Self { core: shape.clone(), reach, pose_bo: None, robot_w: Vector2::zeros(), latency: 0.0 }
    }

    pub(crate) fn new(
        step: &StepInput,
        geometry: Geometry,
        measurement: &MeasurementModel,
    ) -> Result<Self, EffectError> {
        let Outline { core, reach, .. } = Outline::new(step, geometry)?;
        let pose_bo = measurement.pose_bo();
        Ok(Self {
            core: core.unwrap_or_else(|| step.object.shape().clone()),
            reach,
            pose_bo: (pose_bo != Pose::default()).then_some(pose_bo),
            robot_w: measurement.robot_w,
            latency: measurement.latency,
        })
    }

    /// The true place, in m, frame B, of the pusher's center that the robot tells at `center_w`, in W.
    pub fn center_b(&self, pose_wb: &Pose, center_w: &Vector2<f64>) -> Vector2<f64> {
        pose_wb.inverse_transform_point(&(center_w + self.robot_w))
    }

    /// Where the pusher with its center truly at `center_b` touches or would touch, in m, frame B.
    pub fn contact(&self, center_b: &Vector2<f64>) -> Contact {
        let center_o = match &self.pose_bo {
            Some(pose_bo) => pose_bo.inverse_transform_point(center_b),
            None => *center_b,
        };
        let mut contact = self.reach.contact(&self.core, &center_o);
        if let Some(pose_bo) = &self.pose_bo {
            contact.point = pose_bo.transform_point(&contact.point);
            contact.normal = pose_bo.rotate(&contact.normal);
        }
        contact
    }

    /// The true gap between pusher and outline, in m, with the pusher's center told at `center_w` in W.
    pub fn gap(&self, pose_wb: &Pose, center_w: &Vector2<f64>) -> f64 {
        self.contact(&self.center_b(pose_wb, center_w)).gap
    }

    /// The pusher's true radius, in m; 0 where the outline is smaller than stated by more than it.
    pub fn pusher_radius(&self) -> f64 {
        self.reach.pusher_radius.max(0.0)
    }

    /// How late the object's stream is against the robot's, in s.
    pub fn latency(&self) -> f64 {
        self.latency
    }
}

/// How a round pusher touches an outline by its core: the outline moved inwards, which a pusher of that much
/// larger radius touches where it touches the outline itself.
#[derive(Clone, Copy, Debug)]
struct Reach {
    /// In m; of an outline that is smaller than stated by more, less than none.
    pusher_radius: f64,
    /// How far the core is inside the outline, in m.
    inwards: f64,
}

impl Reach {
    /// Nearest point, normal and gap for a pusher's center in the core's frame, in m.
    fn contact(&self, core: &Shape, center_o: &Vector2<f64>) -> Contact {
        let Self { pusher_radius, inwards } = *self;
        let contact = core.contact(center_o, pusher_radius + inwards);
        let outwards = inwards + pusher_radius.min(0.0);
        Contact { point: contact.point - outwards * contact.normal, ..contact }
    }
}

/// The true outline and pusher of one step.
pub(crate) struct Outline<'a> {
    shape: &'a Shape,
    /// If it is not the shape.
    core: Option<Shape>,
    reach: Reach,
    geometry: Geometry,
}

impl<'a> Outline<'a> {
    pub(crate) fn new(step: &'a StepInput, geometry: Geometry) -> Result<Self, EffectError> {
        let shape = step.object.shape();
        let pusher_radius = step.pusher_radius + geometry.radius_excess;
        let inwards = geometry.corner_radius - pusher_radius.min(0.0);
        let core = match shape {
            Shape::Polygon(polygon) if inwards != 0.0 => Some(moved_inwards(polygon, inwards)?),
            Shape::Polygon(_) | Shape::Ellipse(_) => None,
        };
        let inwards = if core.is_some() { inwards } else { 0.0 };
        Ok(Self { shape, core, reach: Reach { pusher_radius, inwards }, geometry })
    }

    /// Nearest point, normal and gap for a pusher's center in the outline's frame, in m.
    pub(crate) fn nearest(&self, center_o: &Vector2<f64>) -> Contact {
        self.reach.contact(self.core.as_ref().unwrap_or(self.shape), center_o)
    }

    /// Way of the pusher before it touches where a push is said to begin, in m.
    pub(crate) fn approach_gap(&self) -> f64 {
        self.geometry.approach_gap
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
