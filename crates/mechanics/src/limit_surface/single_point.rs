//! The limit surface of a single support point.

use crate::limit_surface::{direction_of_twist, direction_of_wrench};
use crate::{LimitSurface, MechanicsError, WrenchSet};
use nalgebra::Vector2;
use planar::{Twist, Wrench, cross, perpendicular};

/// A point that bears any force up to `f_max`: a flat elliptical disc in the space of wrenches.
///
/// Its loads obey M = x Fy − y Fx, so the disc of a point away from the origin tilts along
/// (−y, x), not along the thesis' (x, −y) after its eq. 2.13: a force in that direction has the largest
/// moment. Loads off that plane move the point's body freely, which `level` and `twist` report as
/// `Unbearable`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SinglePoint {
    at: Vector2<f64>,
    f_max: f64,
}

impl SinglePoint {
    /// A point at `at`, in m, that bears `f_max`, in N.
    ///
    /// # Errors
    /// `NotPositive` for the force, `NotFinite` for the place.
    pub fn new(at: Vector2<f64>, f_max: f64) -> Result<Self, MechanicsError> {
        check_point(&at, f_max)?;
        Ok(Self { at, f_max })
    }

    /// Where the point is, in m.
    pub fn at(&self) -> &Vector2<f64> {
        &self.at
    }

    /// What it bears, in N.
    pub fn f_max(&self) -> f64 {
        self.f_max
    }

    /// The load's direction, size and force, if it lies in the plane of the disc.
    fn in_plane(&self, wrench_s: &Wrench) -> Result<(Vector2<f64>, f64), MechanicsError> {
        let (direction, size) = direction_of_wrench(wrench_s)?;
        let force = direction.xy();
        let moment = direction.z - cross(&self.at, &force);
        let scale = direction.z.abs() + self.at.norm() * force.norm();
        if moment.abs() > 1e-12 * scale {
            return Err(MechanicsError::Unbearable { moment: size * moment });
        }
        Ok((force, size))
    }
}

impl LimitSurface for SinglePoint {
    fn dissipation(&self, twist_s: &Twist) -> Result<f64, MechanicsError> {
        let (direction, size) = direction_of_twist(twist_s)?;
        Ok(size * self.f_max * Twist::from_vector(&direction).velocity_at(&self.at).norm())
    }

    fn wrenches(&self, twist_s: &Twist) -> Result<WrenchSet, MechanicsError> {
        let (direction, size) = direction_of_twist(twist_s)?;
        if size == 0.0 {
            return Err(MechanicsError::NoDirection { name: "twist" });
        }
        let velocity = direction.xy() + direction.z * perpendicular(&self.at);
        if velocity.norm() <= rounding(&direction.xy(), direction.z, &self.at) {
            let center = Wrench::default();
            return Ok(WrenchSet::Disc { center, at: self.at, radius: self.f_max });
        }
        let force = self.f_max * velocity.normalize();
        Ok(WrenchSet::Point(Wrench::from_force_at(&force, &self.at)))
    }

    /// # Errors
    /// `Unbearable` for a load with a moment about the point.
    fn level(&self, wrench_s: &Wrench) -> Result<f64, MechanicsError> {
        let (force, size) = self.in_plane(wrench_s)?;
        Ok(size * force.norm() / self.f_max)
    }

    /// Of the many normals at the rim of the disc, the one without rotation.
    ///
    /// # Errors
    /// `Unbearable` for a load with a moment about the point.
    fn twist(&self, wrench_s: &Wrench) -> Result<Twist, MechanicsError> {
        let (force, size) = self.in_plane(wrench_s)?;
        if size == 0.0 {
            return Err(MechanicsError::NoDirection { name: "wrench" });
        }
        Ok(Twist { linear: force.normalize() / self.f_max, angular: 0.0 })
    }

    /// The distance from the origin, 0 for a point there.
    fn characteristic_length(&self) -> f64 {
        self.at.norm()
    }
}

/// Refuses a support point that is nowhere or bears nothing.
pub(crate) fn check_point(at: &Vector2<f64>, f_max: f64) -> Result<(), MechanicsError> {
    if !(f_max > 0.0 && f_max.is_finite()) {
        let name = "friction of a support point";
        return Err(MechanicsError::NotPositive { name, value: f_max, unit: "N" });
    }
    match at.iter().find(|x| !x.is_finite()) {
        Some(&value) => Err(MechanicsError::NotFinite { name: "support point", value, unit: "m" }),
        None => Ok(()),
    }
}

/// The speed below which a point's velocity is lost in rounding.
pub(crate) fn rounding(linear: &Vector2<f64>, angular: f64, at: &Vector2<f64>) -> f64 {
    16.0 * f64::EPSILON * (linear.norm() + angular.abs() * at.norm())
}

#[cfg(test)]
mod tests {
    use super::SinglePoint;
    use crate::{LimitSurface, MechanicsError, WrenchSet};
    use nalgebra::Vector2;
    use planar::{Twist, Wrench};

    #[test]
    fn the_disc_tilts_along_minus_y_x() {
        let point = SinglePoint::new(Vector2::new(0.3, 0.4), 2.0).unwrap();
        let moment =
            |v: Vector2<f64>| point.wrench(&Twist { linear: v, angular: 0.0 }).unwrap().torque;
        assert!((moment(Vector2::new(-0.4, 0.3)) - 2.0 * 0.5).abs() < 1e-15);
        assert!(moment(Vector2::new(0.3, 0.4)).abs() < 1e-15);
    }

    #[test]
    fn a_turn_about_the_point_costs_nothing_and_leaves_its_friction_open() {
        let at = Vector2::new(0.0, 0.5);
        let point = SinglePoint::new(at, 1.0).unwrap();
        let turn = Twist::new(0.5, 0.0, 1.0);
        assert_eq!(point.dissipation(&turn), Ok(0.0));
        let expected = WrenchSet::Disc { center: Wrench::default(), at, radius: 1.0 };
        assert_eq!(point.wrenches(&turn), Ok(expected));
    }

    #[test]
    fn a_load_with_a_moment_about_the_point_is_unbearable() {
        let point = SinglePoint::new(Vector2::new(0.0, 0.5), 1.0).unwrap();
        assert_eq!(point.level(&Wrench::new(0.5, 0.0, -0.25)), Ok(0.5));
        let expected = MechanicsError::Unbearable { moment: 0.25 };
        assert_eq!(point.level(&Wrench::new(0.5, 0.0, 0.0)), Err(expected));
    }

    #[test]
    fn a_point_nowhere_or_without_friction_is_refused() {
        let nowhere = SinglePoint::new(Vector2::new(f64::INFINITY, 0.0), 1.0);
        assert!(matches!(nowhere, Err(MechanicsError::NotFinite { .. })));
        let slippery = SinglePoint::new(Vector2::zeros(), 0.0);
        assert!(matches!(slippery, Err(MechanicsError::NotPositive { .. })));
    }
}
