//! Planar velocities of a rigid body.

use crate::vector_space::vector_space;
use nalgebra::{Vector2, Vector3};
use serde::{Deserialize, Serialize};

/// The velocity of a rigid body in the plane, stated at the origin of a frame.
///
/// It is just as much a small displacement (m, rad) as a velocity (m/s, rad/s).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Twist {
    /// Velocity of the point at the frame's origin, in m/s.
    pub linear: Vector2<f64>,
    /// Rate of turn, counter-clockwise positive, in rad/s.
    pub angular: f64,
}

impl Twist {
    /// A twist from its three numbers, in m/s, m/s and rad/s.
    #[inline]
    pub fn new(vx: f64, vy: f64, omega: f64) -> Self {
        Self { linear: Vector2::new(vx, vy), angular: omega }
    }

    /// (vx, vy, ω) in m/s, m/s and rad/s.
    #[inline]
    pub fn to_vector(&self) -> Vector3<f64> {
        Vector3::new(self.linear.x, self.linear.y, self.angular)
    }

    /// The inverse of [`Twist::to_vector`].
    #[inline]
    pub fn from_vector(vector: &Vector3<f64>) -> Self {
        Self::new(vector.x, vector.y, vector.z)
    }

    /// Velocity of the body's point that is now at `point` (m, same frame), in m/s: V + ω × r.
    ///
    /// The thesis' eq. 2.10 has V − ω × r in front of the same, right components.
    #[inline]
    pub fn velocity_at(&self, point: &Vector2<f64>) -> Vector2<f64> {
        self.linear + self.angular * perpendicular(point)
    }

    /// The same motion stated at `point` (m, same axes) instead of at the origin.
    #[inline]
    pub fn shifted(&self, point: &Vector2<f64>) -> Self {
        Self { linear: self.velocity_at(point), angular: self.angular }
    }
}

vector_space!(Twist { linear, angular });

/// The vector turned by +90°: (x, y) ↦ (−y, x).
#[inline]
pub fn perpendicular(vector: &Vector2<f64>) -> Vector2<f64> {
    Vector2::new(-vector.y, vector.x)
}

/// The out-of-plane part of a × b: a_x b_y − a_y b_x.
#[inline]
pub fn cross(a: &Vector2<f64>, b: &Vector2<f64>) -> f64 {
    a.x * b.y - a.y * b.x
}

#[cfg(test)]
mod tests {
    use super::{Twist, cross, perpendicular};
    use nalgebra::Vector2;

    #[test]
    fn a_pure_turn_moves_a_point_on_the_x_axis_along_y() {
        let v = Twist::new(0.0, 0.0, 2.0).velocity_at(&Vector2::new(0.5, 0.0));
        assert_eq!(v, Vector2::new(0.0, 1.0));
    }

    #[test]
    fn shifting_there_and_back_changes_nothing() {
        let twist = Twist::new(0.25, -0.5, 2.0);
        let point = Vector2::new(0.5, 0.125);
        assert_eq!(twist.shifted(&point).shifted(&-point), twist);
    }

    #[test]
    fn perpendicular_is_a_left_turn() {
        let a = Vector2::new(3.0, 4.0);
        assert_eq!(a.dot(&perpendicular(&a)), 0.0);
        assert_eq!(cross(&a, &perpendicular(&a)), 25.0);
    }
}
