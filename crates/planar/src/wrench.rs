//! Planar forces and moments on a rigid body.

use crate::vector_space::vector_space;
use crate::{Twist, cross};
use nalgebra::{Vector2, Vector3};
use serde::{Deserialize, Serialize};

/// A force and its moment about the origin of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Wrench {
    /// Force, in N.
    pub force: Vector2<f64>,
    /// Moment about the origin, counter-clockwise positive, in N·m.
    pub torque: f64,
}

impl Wrench {
    /// A wrench from its three numbers, in N, N and N·m.
    #[inline]
    pub fn new(fx: f64, fy: f64, torque: f64) -> Self {
        Self { force: Vector2::new(fx, fy), torque }
    }

    /// The wrench of a force (N) that acts at `point` (m, same frame).
    pub fn from_force_at(force: &Vector2<f64>, point: &Vector2<f64>) -> Self {
        Self { force: *force, torque: cross(point, force) }
    }

    /// (Fx, Fy, M) in N, N and N·m.
    #[inline]
    pub fn to_vector(&self) -> Vector3<f64> {
        Vector3::new(self.force.x, self.force.y, self.torque)
    }

    /// The inverse of [`Wrench::to_vector`].
    #[inline]
    pub fn from_vector(vector: &Vector3<f64>) -> Self {
        Self::new(vector.x, vector.y, vector.z)
    }

    /// Power of the wrench on a body that moves with `twist` (same frame), in W.
    pub fn power(&self, twist: &Twist) -> f64 {
        self.force.dot(&twist.linear) + self.torque * twist.angular
    }

    /// The same load with its moment taken about `point` (m, same axes) instead of the origin.
    pub fn shifted(&self, point: &Vector2<f64>) -> Self {
        Self { force: self.force, torque: self.torque - cross(point, &self.force) }
    }
}

vector_space!(Wrench { force, torque });

#[cfg(test)]
mod tests {
    use super::Wrench;
    use crate::Twist;
    use nalgebra::Vector2;

    #[test]
    fn power_is_force_times_the_velocity_of_its_point() {
        let (force, point) = (Vector2::new(2.0, -1.0), Vector2::new(0.5, 0.25));
        let twist = Twist::new(0.5, 1.0, -2.0);
        let power = Wrench::from_force_at(&force, &point).power(&twist);
        assert_eq!(power, force.dot(&twist.velocity_at(&point)));
    }

    #[test]
    fn power_does_not_depend_on_the_reference_point() {
        let (wrench, twist) = (Wrench::new(2.0, -1.0, 0.5), Twist::new(0.5, 1.0, -2.0));
        let point = Vector2::new(0.25, -0.5);
        assert_eq!(wrench.shifted(&point).power(&twist.shifted(&point)), wrench.power(&twist));
    }

    #[test]
    fn a_force_has_no_moment_about_its_own_point() {
        let (force, point) = (Vector2::new(2.0, -1.0), Vector2::new(0.5, 0.25));
        assert_eq!(Wrench::from_force_at(&force, &point).shifted(&point).torque, 0.0);
    }
}
