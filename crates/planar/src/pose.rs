//! Where a frame is in another one: the group SE(2).

use crate::Twist;
use nalgebra::{Matrix3, Vector2};
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// Position and orientation of one frame in another, `pose_wb` for frame B in frame W.
///
/// Poses compose by `*`: `pose_wc = pose_wb * pose_bc`. The angle is kept as it is summed, so a
/// turn beyond ±π stays readable; [`wrap_angle`] brings it back.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// Origin of the inner frame in the outer one, in m.
    pub position: Vector2<f64>,
    /// Turn of the inner frame against the outer one, counter-clockwise positive, in rad.
    pub angle: f64,
}

impl Pose {
    /// A pose from its three numbers, in m, m and rad.
    #[inline]
    pub fn new(x: f64, y: f64, angle: f64) -> Self {
        Self { position: Vector2::new(x, y), angle }
    }

    /// A vector (not a point) of the inner frame, in the axes of the outer one.
    #[inline]
    pub fn rotate(&self, vector: &Vector2<f64>) -> Vector2<f64> {
        let (sin, cos) = self.angle.sin_cos();
        Vector2::new(cos * vector.x - sin * vector.y, sin * vector.x + cos * vector.y)
    }

    /// A vector (not a point) of the outer frame, in the axes of the inner one.
    #[inline]
    pub fn inverse_rotate(&self, vector: &Vector2<f64>) -> Vector2<f64> {
        let (sin, cos) = self.angle.sin_cos();
        Vector2::new(cos * vector.x + sin * vector.y, cos * vector.y - sin * vector.x)
    }

    /// A point of the inner frame (m), in the outer one.
    #[inline]
    pub fn transform_point(&self, point: &Vector2<f64>) -> Vector2<f64> {
        self.position + self.rotate(point)
    }

    /// A point of the outer frame (m), in the inner one.
    #[inline]
    pub fn inverse_transform_point(&self, point: &Vector2<f64>) -> Vector2<f64> {
        self.inverse_rotate(&(point - self.position))
    }

    /// The outer frame in the inner one.
    pub fn inverse(&self) -> Self {
        Self { position: -self.inverse_rotate(&self.position), angle: -self.angle }
    }

    /// Where a frame gets in unit time under a constant twist stated in its own moving axes.
    ///
    /// The exponential map: `pose_wb * Pose::exp(&(dt * twist_wb_b))` moves along a circular arc.
    pub fn exp(twist: &Twist) -> Self {
        let (sinc, cosc) = arc_coefficients(twist.angular);
        let v = &twist.linear;
        let position = Vector2::new(sinc * v.x - cosc * v.y, cosc * v.x + sinc * v.y);
        Self { position, angle: twist.angular }
    }

    /// The constant twist, in the moving axes, that reaches this pose in unit time.
    ///
    /// Inverse of [`Pose::exp`] for every angle but the non-zero multiples of 2π, where no arc
    /// (or every arc) leads there; valid in −2π < angle < 2π.
    pub fn log(&self) -> Twist {
        let (sinc, cosc) = arc_coefficients(self.angle);
        let scale = 1.0 / (sinc * sinc + cosc * cosc);
        let p = &self.position;
        let linear = scale * Vector2::new(sinc * p.x + cosc * p.y, sinc * p.y - cosc * p.x);
        Twist { linear, angular: self.angle }
    }

    /// The 3×3 matrix that brings a twist (vx, vy, ω) from the inner frame to the outer one.
    ///
    /// Its inverse transpose does the same to a wrench (Fx, Fy, M).
    pub fn adjoint(&self) -> Matrix3<f64> {
        let (sin, cos) = self.angle.sin_cos();
        let (x, y) = (self.position.x, self.position.y);
        Matrix3::new(cos, -sin, y, sin, cos, -x, 0.0, 0.0, 1.0)
    }
}

impl std::ops::Mul for Pose {
    type Output = Pose;

    // Turns add where poses compose.
    #[allow(clippy::suspicious_arithmetic_impl)]
    #[inline]
    fn mul(self, inner: Pose) -> Pose {
        Pose { position: self.transform_point(&inner.position), angle: self.angle + inner.angle }
    }
}

/// The same angle in (−π, π], in rad.
pub fn wrap_angle(angle: f64) -> f64 {
    let wrapped = angle.rem_euclid(TAU);
    if wrapped > PI { wrapped - TAU } else { wrapped }
}

/// sin(a)/a and (1 − cos a)/a, without loss of digits near zero.
fn arc_coefficients(angle: f64) -> (f64, f64) {
    if angle.abs() < 1e-4 {
        let square = angle * angle;
        return (1.0 - square / 6.0, 0.5 * angle * (1.0 - square / 12.0));
    }
    let half = (0.5 * angle).sin();
    (angle.sin() / angle, 2.0 * half * half / angle)
}

#[cfg(test)]
mod tests {
    use super::{Pose, wrap_angle};
    use crate::{Twist, Wrench};
    use nalgebra::{Vector2, Vector3};
    use proptest::prelude::{Strategy, prop_assert, proptest};
    use std::f64::consts::{FRAC_PI_2, PI};

    fn pose() -> impl Strategy<Value = Pose> {
        (-2.0..2.0f64, -2.0..2.0f64, -3.1..3.1f64).prop_map(|(x, y, a)| Pose::new(x, y, a))
    }

    fn distance(a: &Pose, b: &Pose) -> f64 {
        (a.position - b.position).norm() + (a.angle - b.angle).abs()
    }

    proptest! {
        #[test]
        fn a_pose_times_its_inverse_is_the_identity(a in pose()) {
            prop_assert!(distance(&(a * a.inverse()), &Pose::default()) < 1e-14);
        }

        #[test]
        fn composition_is_associative(a in pose(), b in pose(), c in pose()) {
            prop_assert!(distance(&((a * b) * c), &(a * (b * c))) < 1e-13);
        }

        #[test]
        fn log_undoes_exp(a in pose(), scale in 1e-9..1.0f64) {
            let twist = scale * Twist::new(a.position.x, a.position.y, a.angle);
            let back = Pose::exp(&twist).log();
            prop_assert!((back - twist).to_vector().norm() < 1e-13 * (1.0 + scale));
        }

        #[test]
        fn exp_of_parts_composes_to_exp_of_the_whole(a in pose(), share in 0.0..1.0f64) {
            let twist = a.log();
            let parts = Pose::exp(&(share * twist)) * Pose::exp(&((1.0 - share) * twist));
            prop_assert!(distance(&parts, &a) < 1e-13);
        }

        #[test]
        fn the_adjoint_moves_twists_and_its_inverse_transpose_moves_wrenches(
            a in pose(), t in pose(), w in pose(),
        ) {
            let twist_b = Vector3::new(t.position.x, t.position.y, t.angle);
            let wrench_b = Vector3::new(w.position.x, w.position.y, w.angle);
            let twist_w = Twist::from_vector(&(a.adjoint() * twist_b));
            let moved = a.inverse().adjoint().transpose() * wrench_b;
            let power_w = Wrench::from_vector(&moved).power(&twist_w);
            prop_assert!((power_w - wrench_b.dot(&twist_b)).abs() < 1e-12);
            let v_b = Twist::from_vector(&twist_b).velocity_at(&Vector2::new(0.3, -0.2));
            let point_w = a.transform_point(&Vector2::new(0.3, -0.2));
            prop_assert!((twist_w.velocity_at(&point_w) - a.rotate(&v_b)).norm() < 1e-12);
        }

        #[test]
        fn a_wrapped_angle_points_the_same_way(angle in -50.0..50.0f64) {
            let wrapped = wrap_angle(angle);
            prop_assert!(wrapped > -PI && wrapped <= PI);
            prop_assert!((wrapped.sin() - angle.sin()).abs() < 1e-13);
            prop_assert!((wrapped.cos() - angle.cos()).abs() < 1e-13);
        }
    }

    #[test]
    fn a_quarter_arc_of_unit_radius_ends_at_one_one() {
        let end = Pose::exp(&Twist::new(FRAC_PI_2, 0.0, FRAC_PI_2));
        assert!(distance(&end, &Pose::new(1.0, 1.0, FRAC_PI_2)) < 1e-15);
    }

    #[test]
    fn exp_is_smooth_where_its_series_takes_over() {
        for angle in [0.99e-4, 1.01e-4] {
            let end = Pose::exp(&Twist::new(1.0, 0.0, angle));
            assert!((end.position.x - angle.sin() / angle).abs() < 1e-16 * 4.0);
            let versine = 2.0 * (0.5 * angle).sin().powi(2);
            assert!((end.position.y - versine / angle).abs() < 1e-19 * 4.0);
        }
    }
}
