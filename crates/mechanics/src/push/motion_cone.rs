//! The motion cone: pusher velocities that the contact follows without sliding.

use crate::{CenterOfRotation, FrictionCone, LimitSurface, MechanicsError, Push};
use nalgebra::{Unit, UnitVector2, Vector2};
use planar::{Twist, cross};

/// Velocities of the contact point between those under the two edges of the friction cone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionCone {
    /// Motion under a force along the friction cone's left edge, scaled as [`LimitSurface::twist`].
    pub left_twist_s: Twist,
    /// Motion under a force along the right edge.
    pub right_twist_s: Twist,
    /// Direction of the contact point's velocity under a force on the left edge.
    pub left: UnitVector2<f64>,
    /// The same on the right edge.
    pub right: UnitVector2<f64>,
}

impl MotionCone {
    /// The cone from the limit surface's normals at the loads of the friction cone's edges.
    ///
    /// Takes the contact from `push`, whose velocity does not matter.
    ///
    /// # Errors
    /// A push that is not finite, a negative friction, or errors of the surface.
    pub fn new(surface: &dyn LimitSurface, push: &Push) -> Result<Self, MechanicsError> {
        push.validate()?;
        let edges = FrictionCone::new(push.normal_s, push.friction)?.edges();
        let [left_twist_s, right_twist_s] = edges.map(|edge| surface.twist(&push.wrench_of(&edge)));
        let (left_twist_s, right_twist_s) = (left_twist_s?, right_twist_s?);
        let direction = |twist: &Twist| direction_of(twist.velocity_at(&push.p_sc));
        let (left, right) = (direction(&left_twist_s)?, direction(&right_twist_s)?);
        Ok(Self { left_twist_s, right_twist_s, left, right })
    }

    /// The cone's edges by Mason's construction: normal to the lines from the contact to the two
    /// centers of rotation, turned by their senses.
    ///
    /// # Errors
    /// `NoDirection` if the contact is at a center of rotation.
    pub fn edges_from_centers(
        p_sc: &Vector2<f64>,
        centers: &[CenterOfRotation; 2],
    ) -> Result<[UnitVector2<f64>; 2], MechanicsError> {
        let velocity =
            |center: &CenterOfRotation| direction_of(center.twist(1.0).velocity_at(p_sc));
        Ok([velocity(&centers[0])?, velocity(&centers[1])?])
    }

    /// The centers of rotation under forces along the left and the right edge of the friction cone.
    pub fn centers(&self) -> [CenterOfRotation; 2] {
        [CenterOfRotation::of(&self.left_twist_s), CenterOfRotation::of(&self.right_twist_s)]
    }

    /// Whether the contact sticks to a pusher with `velocity`; on the cone's edge it does.
    pub fn contains(&self, velocity: &Vector2<f64>) -> bool {
        cross(&self.right, velocity) >= 0.0
            && cross(velocity, &self.left) >= 0.0
            && (self.left.into_inner() + self.right.into_inner()).dot(velocity) >= 0.0
    }
}

fn direction_of(velocity: Vector2<f64>) -> Result<UnitVector2<f64>, MechanicsError> {
    Unit::try_new(velocity, 0.0)
        .ok_or(MechanicsError::NoDirection { name: "the contact point's velocity" })
}
