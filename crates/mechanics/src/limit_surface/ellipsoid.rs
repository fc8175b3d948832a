//! The ellipsoidal limit surface.

use crate::limit_surface::{direction_of_twist, direction_of_wrench};

use crate::{LimitSurface, MechanicsError, UniformPressure, WrenchSet};
use nalgebra::{Matrix3, Vector2, Vector3};
use planar::{Shape, Twist, Wrench};

/// wᵀ A w = 1 for w = (Fx, Fy, M), with A symmetric and positive definite.
///
/// Upright and centered it is (Fx² + Fy²)/Fmax² + M²/Mmax² = 1. Its gradient there is
/// (2Fx/Fmax², 2Fy/Fmax², 2M/Mmax²), which gives vx/ω = c² Fx/M with c = Mmax/Fmax; the thesis'
/// eq. 2.15 lacks the squares in the denominators, its eq. 2.16 has them.
///
/// # Source
/// Lee & Cutkosky (1991), "Fixture planning with friction".
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipsoid {
    matrix: Matrix3<f64>,
    inverse: Matrix3<f64>,
}

impl Ellipsoid {
    /// An upright, centered ellipsoid from its largest force, in N, and largest moment, in N·m.
    ///
    /// # Errors
    /// `NotPositive` if one of them is not positive and finite.
    pub fn new(f_max: f64, tau_max: f64) -> Result<Self, MechanicsError> {
        for (name, value, unit) in [("f_max", f_max, "N"), ("tau_max", tau_max, "N·m")] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(MechanicsError::NotPositive { name, value, unit });
            }
        }
        let axes = Vector3::new(f_max * f_max, f_max * f_max, tau_max * tau_max);
        Self::from_inverse(Matrix3::from_diagonal(&axes))
    }

    /// A general ellipsoid from A, in 1/N², 1/(N²·m) and 1/(N²·m²).
    ///
    /// # Errors
    /// `NotPositiveDefinite` if the matrix is not symmetric, finite and positive definite.
    pub fn from_matrix(matrix: Matrix3<f64>) -> Result<Self, MechanicsError> {
        let inverse = checked_inverse("ellipsoid matrix", &matrix)?;
        Ok(Self { matrix, inverse })
    }

    /// A general ellipsoid from A⁻¹: the dissipation's square is tᵀ A⁻¹ t.
    ///
    /// # Errors
    /// `NotPositiveDefinite` if the matrix is not symmetric, finite and positive definite.
    pub fn from_inverse(inverse: Matrix3<f64>) -> Result<Self, MechanicsError> {
        let matrix = checked_inverse("inverse ellipsoid matrix", &inverse)?;
        Ok(Self { matrix, inverse })
    }

    /// The ellipsoid of uniform pressure over `shape`, in the shape's frame.
    ///
    /// It is upright about the centroid, with Mmax = Fmax · (mean distance to the centroid), positive
    /// where the thesis' eq. 2.20 has a minus; where the centroid is not the frame's origin it is
    /// tilted. `f_max` is friction times load, in N.
    ///
    /// # Errors
    /// `NotPositive` if `f_max` is not positive and finite.
    pub fn uniform(shape: &Shape, f_max: f64) -> Result<Self, MechanicsError> {
        let center = shape.centroid();
        Self::new(f_max, f_max * shape.mean_distance(&center))?.shifted(&-center)
    }

    /// The ellipsoid through three true loads of `surface`: those of the motions along x, along y
    /// and about the center of friction, which become conjugate half axes (A⁻¹ = Σ w wᵀ).
    ///
    /// The turn keeps exactly its true load, net force included; that force is zero only where the
    /// center of friction is also the center of torsion. The thesis' section 2.4 takes them for one
    /// point always: in the triangles of [`planar::mit_object`] that leaves out 3.4 to 4.3 % of Fmax.
    ///
    /// # Errors
    /// Those of the surface, and `NotPositiveDefinite` if the loads lie in a plane.
    pub fn through_loads(surface: &dyn LimitSurface) -> Result<Self, MechanicsError> {
        let along_x = surface.wrench(&Twist::new(1.0, 0.0, 0.0))?;
        let along_y = surface.wrench(&Twist::new(0.0, 1.0, 0.0))?;
        let center = Vector2::new(
            along_y.torque / along_y.force.norm(),
            -along_x.torque / along_x.force.norm(),
        );
        let turn = surface.wrench(&Twist::new(center.y, -center.x, 1.0))?;
        let loads = [along_x, along_y, turn].map(|load| load.to_vector());
        Self::from_inverse(loads.iter().map(|load| load * load.transpose()).sum())
    }

    /// The same surface about another reference point, `point` in m in the present frame.
    ///
    /// # Errors
    /// `NotPositiveDefinite` if the point is not finite, or too far away for double precision.
    pub fn shifted(&self, point: &Vector2<f64>) -> Result<Self, MechanicsError> {
        // M' = M − (x Fy − y Fx)
        let map = Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, point.y, -point.x, 1.0);
        let inverse = map * self.inverse * map.transpose();
        Self::from_inverse(0.5 * (inverse + inverse.transpose()))
    }

    /// A, which maps a load on the surface to its motion.
    pub fn matrix(&self) -> &Matrix3<f64> {
        &self.matrix
    }

    /// A⁻¹, which maps a motion of unit dissipation to its load.
    pub fn inverse(&self) -> &Matrix3<f64> {
        &self.inverse
    }
}

impl UniformPressure for Ellipsoid {
    const NAME: &'static str = "ellipsoid";

    fn over(shape: &Shape, f_max: f64) -> Result<Self, MechanicsError> {
        Self::uniform(shape, f_max)
    }
}

impl LimitSurface for Ellipsoid {
    fn dissipation(&self, twist_s: &Twist) -> Result<f64, MechanicsError> {
        let (direction, size) = direction_of_twist(twist_s)?;
        Ok(size * direction.dot(&(self.inverse * direction)).sqrt())
    }

    fn wrenches(&self, twist_s: &Twist) -> Result<WrenchSet, MechanicsError> {
        let (direction, size) = direction_of_twist(twist_s)?;
        if size == 0.0 {
            return Err(MechanicsError::NoDirection { name: "twist" });
        }
        let load = self.inverse * direction;
        let wrench = load / direction.dot(&load).sqrt();
        Ok(WrenchSet::Point(Wrench::from_vector(&wrench)))
    }

    fn level(&self, wrench_s: &Wrench) -> Result<f64, MechanicsError> {
        let (direction, size) = direction_of_wrench(wrench_s)?;
        Ok(size * direction.dot(&(self.matrix * direction)).sqrt())
    }

    fn twist(&self, wrench_s: &Wrench) -> Result<Twist, MechanicsError> {
        let (direction, size) = direction_of_wrench(wrench_s)?;
        if size == 0.0 {
            return Err(MechanicsError::NoDirection { name: "wrench" });
        }
        let motion = self.matrix * direction;
        Ok(Twist::from_vector(&(motion / direction.dot(&motion).sqrt())))
    }

    fn characteristic_length(&self) -> f64 {
        let force = 0.5 * (self.inverse[(0, 0)] + self.inverse[(1, 1)]);
        (self.inverse[(2, 2)] / force).sqrt()
    }

    fn quadric(&self) -> Option<&Matrix3<f64>> {
        Some(&self.matrix)
    }
}

/// The inverse of a symmetric, positive definite matrix, balanced first because forces and moments
/// differ in size.
fn checked_inverse(
    name: &'static str,
    matrix: &Matrix3<f64>,
) -> Result<Matrix3<f64>, MechanicsError> {
    let refused = || MechanicsError::NotPositiveDefinite { name, columns: (*matrix).into() };
    let diagonal = matrix.diagonal();
    if !matrix.iter().all(|x| x.is_finite()) || diagonal.min() <= 0.0 {
        return Err(refused());
    }
    let balance = Matrix3::from_diagonal(&diagonal.map(|x| x.sqrt().recip()));
    let balanced = balance * matrix * balance;
    if (balanced - balanced.transpose()).amax() > 1e-12 {
        return Err(refused());
    }
    let inverse = balanced.cholesky().ok_or_else(refused)?.inverse();
    if !inverse.iter().all(|x| x.abs() < 1e14) {
        return Err(refused());
    }
    Ok(balance * inverse * balance)
}

#[cfg(test)]
mod tests {
    use super::Ellipsoid;
    use crate::{LimitSurface, MechanicsError};
    use nalgebra::{Matrix3, Vector2};
    use planar::{MIT_NAMES, Shape, Twist, Wrench, mit_object};

    #[test]
    fn the_velocity_ratio_is_the_square_of_the_characteristic_length() {
        let c = 0.04;
        let twist = Ellipsoid::new(2.0, 2.0 * c).unwrap().twist(&Wrench::new(1.0, 0.3, 0.02));
        let twist = twist.unwrap();
        assert!((twist.linear.x / twist.angular - c * c * 1.0 / 0.02).abs() < 1e-15);
        assert!((twist.linear.y / twist.angular - c * c * 0.3 / 0.02).abs() < 1e-15);
    }

    #[test]
    fn a_uniform_square_has_the_closed_form_characteristic_length() {
        let surface = Ellipsoid::uniform(&Shape::square(0.09).unwrap(), 2.05).unwrap();
        let expected = 0.09 * (2.0_f64.sqrt() + (1.0 + 2.0_f64.sqrt()).ln()) / 6.0;
        assert!((surface.characteristic_length() - expected).abs() < 1e-15);
    }

    #[test]
    fn about_its_centroid_the_uniform_ellipsoid_of_every_shape_is_upright() {
        for name in MIT_NAMES {
            let shape = mit_object(name).unwrap().shape;
            let center = shape.centroid();
            let surface = Ellipsoid::uniform(&shape, 2.0).unwrap();
            let about_center = surface.shifted(&center).unwrap();
            let force = about_center.wrench(&Twist::new(0.0, 0.0, 1.0)).unwrap().force;
            assert!(force.norm() < 1e-14, "{name}");
        }
    }

    #[test]
    fn power_and_level_do_not_depend_on_the_reference_point() {
        let tilted = Matrix3::new(1.0, 0.2, 3.0, 0.2, 2.0, -4.0, 3.0, -4.0, 500.0);
        let surface = Ellipsoid::from_matrix(tilted).unwrap();
        let point = Vector2::new(0.05, -0.02);
        let moved = surface.shifted(&point).unwrap();
        let (wrench, twist) = (Wrench::new(0.5, -0.2, 0.01), Twist::new(0.01, 0.02, -0.5));
        let level = moved.level(&wrench.shifted(&point)).unwrap();
        assert!((level - surface.level(&wrench).unwrap()).abs() < 1e-14);
        let power = moved.dissipation(&twist.shifted(&point)).unwrap();
        assert!((power - surface.dissipation(&twist).unwrap()).abs() < 1e-14);
    }

    #[test]
    fn very_small_and_very_large_motions_keep_their_load() {
        let surface = Ellipsoid::new(2.0, 0.08).unwrap();
        let wrench = surface.wrench(&Twist::new(1.0, 2.0, -30.0)).unwrap();
        for size in [1e-300, 1e300] {
            let scaled = surface.wrench(&(size * Twist::new(1.0, 2.0, -30.0))).unwrap();
            assert!((scaled - wrench).to_vector().norm() < 1e-14);
        }
    }

    #[test]
    fn bad_input_is_refused_with_its_reason() {
        let zero = Ellipsoid::new(2.0, 0.0);
        let expected = MechanicsError::NotPositive { name: "tau_max", value: 0.0, unit: "N·m" };
        assert_eq!(zero, Err(expected));
        let saddle = Ellipsoid::from_matrix(Matrix3::new(1., 2., 0., 2., 1., 0., 0., 0., 1.));
        assert!(matches!(saddle, Err(MechanicsError::NotPositiveDefinite { .. })));
        let crooked = Ellipsoid::from_matrix(Matrix3::new(1., 0.1, 0., 0., 1., 0., 0., 0., 1.));
        assert!(matches!(crooked, Err(MechanicsError::NotPositiveDefinite { .. })));
        let surface = Ellipsoid::new(2.0, 0.08).unwrap();
        let nan = surface.dissipation(&Twist::new(0.0, f64::NAN, 0.0));
        assert!(matches!(nan, Err(MechanicsError::NotFinite { name: "twist", .. })));
        let infinite = surface.level(&Wrench::new(0.0, 0.0, f64::INFINITY));
        assert!(matches!(infinite, Err(MechanicsError::NotFinite { name: "wrench", .. })));
        let still = surface.wrench(&Twist::default());
        assert_eq!(still, Err(MechanicsError::NoDirection { name: "twist" }));
        let idle = surface.twist(&Wrench::default());
        assert_eq!(idle, Err(MechanicsError::NoDirection { name: "wrench" }));
    }
}
