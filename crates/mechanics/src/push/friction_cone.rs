//! Coulomb's friction cone at a contact.

use crate::MechanicsError;
use nalgebra::{SVector, Unit, UnitVector2, Vector2};
use planar::perpendicular;

/// The forces a contact with dry friction can pass, in `N` = 2 or 3 dimensions.
///
/// |f − (n·f) n| ≤ μ n·f, with n the unit normal into the object that is pushed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrictionCone<const N: usize> {
    normal: Unit<SVector<f64, N>>,
    friction: f64,
}

impl<const N: usize> FrictionCone<N> {
    /// A cone around `normal` for the coefficient of friction μ.
    ///
    /// # Errors
    /// `Negative` if μ is negative or not finite.
    pub fn new(normal: Unit<SVector<f64, N>>, friction: f64) -> Result<Self, MechanicsError> {
        if !(friction >= 0.0 && friction.is_finite()) {
            let (name, unit) = ("the friction coefficient", "(dimensionless)");
            return Err(MechanicsError::Negative { name, value: friction, unit });
        }
        Ok(Self { normal, friction })
    }

    /// The cone's axis, into the object.
    pub fn normal(&self) -> &Unit<SVector<f64, N>> {
        &self.normal
    }

    /// Half the opening angle, atan μ, in rad.
    pub fn half_angle(&self) -> f64 {
        self.friction.atan()
    }

    /// Whether the contact can pass `force`; on the edge it can.
    pub fn contains(&self, force: &SVector<f64, N>) -> bool {
        let (along, across) = self.split(force);
        across.norm() <= self.friction * along
    }

    /// The force in the cone that is nearest to `force`.
    pub fn project(&self, force: &SVector<f64, N>) -> SVector<f64, N> {
        let (along, across) = self.split(force);
        let sideways = across.norm();
        if sideways <= self.friction * along {
            return *force;
        }
        // On the edge, or at the apex for forces within the polar cone.
        let share = (along + self.friction * sideways).max(0.0) / (1.0 + self.friction.powi(2));
        share
            * (self.normal.into_inner() + self.friction / sideways.max(f64::MIN_POSITIVE) * across)
    }

    /// The parts of a force along the normal, and across it.
    fn split(&self, force: &SVector<f64, N>) -> (f64, SVector<f64, N>) {
        let along = self.normal.dot(force);
        (along, force - along * self.normal.into_inner())
    }
}

impl FrictionCone<2> {
    /// Directions of the left and the right edge; left is turned counter-clockwise from the normal.
    pub fn edges(&self) -> [UnitVector2<f64>; 2] {
        let normal: Vector2<f64> = self.normal.into_inner();
        let sideways = self.friction * perpendicular(&normal);
        [Unit::new_normalize(normal + sideways), Unit::new_normalize(normal - sideways)]
    }
}

#[cfg(test)]
mod tests {
    use super::FrictionCone;
    use crate::MechanicsError;
    use nalgebra::{Unit, Vector2, Vector3};
    use proptest::prelude::{prop_assert, proptest};

    #[test]
    fn the_edges_are_the_angle_of_friction_away_from_the_normal() {
        let cone = FrictionCone::new(Vector2::x_axis(), 0.75).unwrap();
        let [left, right] = cone.edges();
        assert!((left.into_inner() - Vector2::new(0.8, 0.6)).norm() < 1e-15);
        assert!((right.into_inner() - Vector2::new(0.8, -0.6)).norm() < 1e-15);
        assert!((cone.half_angle().tan() - 0.75).abs() < 1e-15);
    }

    #[test]
    fn a_force_on_the_edge_is_inside_and_a_pull_is_not() {
        let cone = FrictionCone::new(Vector3::z_axis(), 0.5).unwrap();
        assert!(cone.contains(&Vector3::new(0.3, 0.4, 1.0)));
        assert!(!cone.contains(&Vector3::new(0.4, 0.4, 1.0)));
        assert!(!cone.contains(&Vector3::new(0.0, 0.0, -1.0)));
        assert_eq!(cone.project(&Vector3::new(0.1, 0.0, -1.0)), Vector3::zeros());
    }

    #[test]
    fn negative_friction_is_refused() {
        let error = FrictionCone::new(Vector2::x_axis(), -0.5).unwrap_err();
        let (name, unit) = ("the friction coefficient", "(dimensionless)");
        assert_eq!(error, MechanicsError::Negative { name, value: -0.5, unit });
    }

    proptest! {
        #[test]
        fn the_projection_is_the_nearest_force_of_the_cone(
            f in (-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64),
            g in (-1.0..1.0f64, -1.0..1.0f64, 0.0..1.0f64),
            friction in 0.01..3.0f64,
        ) {
            let normal = Unit::new_normalize(Vector3::new(0.3, -0.2, 0.9));
            let cone = FrictionCone::new(normal, friction).unwrap();
            let (force, other) = (Vector3::new(f.0, f.1, f.2), Vector3::new(g.0, g.1, g.2));
            let projected = cone.project(&force);
            let inside = projected + 1e-12 * normal.into_inner();
            prop_assert!(cone.contains(&inside));
            // Nearest to a convex set: no point of the set is at less than a right angle.
            if cone.contains(&other) {
                prop_assert!((force - projected).dot(&(other - projected)) <= 1e-12);
            }
            prop_assert!((force - projected).dot(&projected).abs() <= 1e-12);
        }
    }
}
