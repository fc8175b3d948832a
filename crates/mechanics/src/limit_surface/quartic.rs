//! The convex quartic limit surface.

use crate::limit_surface::polar::{Homogeneous, polar};
use crate::limit_surface::{direction_of_twist, direction_of_wrench};
use crate::{Ellipsoid, LimitSurface, MechanicsError, WrenchSet};
use nalgebra::{Matrix3, Vector3};
use planar::{Twist, Wrench};
use std::collections::VecDeque;

/// H(w) = Σ cᵢ Fx^a Fy^b (M/ρ)^c = 1 over the fifteen monomials of degree four, certified convex.
///
/// The level is H^(1/4), the motion its gradient.
///
/// # Source
/// Zhou, Paolini, Bagnell & Mason (2016), "A convex polynomial force-motion model for planar
/// sliding: identification and application".
#[derive(Clone, Debug, PartialEq)]
pub struct Quartic {
    coefficients: [f64; 15],
    length: f64,
}

/// The exponents (a, b, c) of Fx, Fy and M/ρ, in the order of the coefficients.
pub const QUARTIC_EXPONENTS: [[usize; 3]; 15] = [
    [4, 0, 0],
    [3, 1, 0],
    [3, 0, 1],
    [2, 2, 0],
    [2, 1, 1],
    [2, 0, 2],
    [1, 3, 0],
    [1, 2, 1],
    [1, 1, 2],
    [1, 0, 3],
    [0, 4, 0],
    [0, 3, 1],
    [0, 2, 2],
    [0, 1, 3],
    [0, 0, 4],
];

const MAX_CELLS: usize = 300_000;

impl Quartic {
    /// A quartic from its coefficients, in 1/N⁴ in the order of [`QUARTIC_EXPONENTS`], and ρ in m.
    ///
    /// Convexity is proved by branch and bound over all directions of load: the smallest eigenvalue
    /// of the Hessian at the middle of a cell, less a Lipschitz bound times the cell's radius, must
    /// be positive.
    ///
    /// # Errors
    /// `NotPositive` for the length, `NotFinite` for a coefficient, `NotConvex` with the offending
    /// direction, `ConvexityUndecided` if the smallest curvature is (nearly) zero.
    pub fn new(coefficients: [f64; 15], length: f64) -> Result<Self, MechanicsError> {
        if !(length > 0.0 && length.is_finite()) {
            let name = "characteristic length";
            return Err(MechanicsError::NotPositive { name, value: length, unit: "m" });
        }
        if let Some(&value) = coefficients.iter().find(|c| !c.is_finite()) {
            return Err(MechanicsError::NotFinite { name: "coefficient", value, unit: "1/N⁴" });
        }
        certify(&coefficients)?;
        Ok(Self { coefficients, length })
    }

    /// The quartic that is the same surface as an ellipsoid: H = (wᵀ A w)².
    ///
    /// # Errors
    /// `ConvexityUndecided` if the ellipsoid is extremely elongated in the scaled space.
    pub fn from_ellipsoid(ellipsoid: &Ellipsoid) -> Result<Self, MechanicsError> {
        let length = ellipsoid.characteristic_length();
        let scale = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, length));
        Self::new(squared(&(scale * ellipsoid.matrix() * scale)), length)
    }

    /// The coefficients, in 1/N⁴ in the order of [`QUARTIC_EXPONENTS`].
    pub fn coefficients(&self) -> &[f64; 15] {
        &self.coefficients
    }

    fn scaled_wrench(&self, direction: &Vector3<f64>) -> Vector3<f64> {
        Vector3::new(direction.x, direction.y, direction.z / self.length)
    }
}

impl LimitSurface for Quartic {
    /// By Newton's method, to a relative error of about 1e-13.
    fn dissipation(&self, twist_s: &Twist) -> Result<f64, MechanicsError> {
        let (direction, size) = direction_of_twist(twist_s)?;
        if size == 0.0 {
            return Ok(0.0);
        }
        let y = Vector3::new(direction.x, direction.y, direction.z * self.length);
        Ok(size * polar("dissipation of a quartic", self, &y, None)?.value)
    }

    fn wrenches(&self, twist_s: &Twist) -> Result<WrenchSet, MechanicsError> {
        let (direction, size) = direction_of_twist(twist_s)?;
        if size == 0.0 {
            return Err(MechanicsError::NoDirection { name: "twist" });
        }
        let y = Vector3::new(direction.x, direction.y, direction.z * self.length);
        let load = polar("load of a quartic", self, &y, None)?.normal;
        Ok(WrenchSet::Point(Wrench::new(load.x, load.y, load.z * self.length)))
    }

    fn level(&self, wrench_s: &Wrench) -> Result<f64, MechanicsError> {
        let (direction, size) = direction_of_wrench(wrench_s)?;
        let value = polynomial(&self.coefficients, &self.scaled_wrench(&direction));
        Ok(size * value.sqrt().sqrt())
    }

    fn twist(&self, wrench_s: &Wrench) -> Result<Twist, MechanicsError> {
        let (direction, size) = direction_of_wrench(wrench_s)?;
        if size == 0.0 {
            return Err(MechanicsError::NoDirection { name: "wrench" });
        }
        let (_, gradient) = self.value(&self.scaled_wrench(&direction))?;
        Ok(Twist::new(gradient.x, gradient.y, gradient.z / self.length))
    }

    /// The ρ that scales the moments.
    fn characteristic_length(&self) -> f64 {
        self.length
    }
}

/// The level as a function of (Fx, Fy, M/ρ).
impl Homogeneous for Quartic {
    fn value(&self, x: &Vector3<f64>) -> Result<(f64, Vector3<f64>), MechanicsError> {
        let level = polynomial(&self.coefficients, x).sqrt().sqrt();
        // grad H = H″ w / 3 for a form of degree four.
        let gradient = hessian(&self.coefficients, x) * x / 3.0;
        Ok((level, gradient / (4.0 * level.powi(3))))
    }

    fn hessian(&self, x: &Vector3<f64>) -> Result<Matrix3<f64>, MechanicsError> {
        let (level, gradient) = self.value(x)?;
        let curvature = hessian(&self.coefficients, x) / (4.0 * level.powi(3));
        Ok(curvature - 3.0 / level * gradient * gradient.transpose())
    }
}

pub(crate) fn polynomial(coefficients: &[f64; 15], w: &Vector3<f64>) -> f64 {
    let monomial = |e: &[usize; 3]| (0..3).map(|i| power(w[i], e[i])).product::<f64>();
    coefficients.iter().zip(&QUARTIC_EXPONENTS).map(|(c, e)| c * monomial(e)).sum()
}

/// The gradient of each monomial times its coefficient, summed.
pub(crate) fn gradient(coefficients: &[f64; 15], w: &Vector3<f64>) -> Vector3<f64> {
    hessian(coefficients, w) * w / 3.0
}

pub(crate) fn hessian(coefficients: &[f64; 15], w: &Vector3<f64>) -> Matrix3<f64> {
    let powers: [[f64; 5]; 3] = std::array::from_fn(|i| std::array::from_fn(|k| power(w[i], k)));
    let mut hessian = Matrix3::zeros();
    for (c, exponents) in coefficients.iter().zip(&QUARTIC_EXPONENTS) {
        for i in 0..3 {
            for j in 0..=i {
                let mut e = *exponents;
                let mut factor = e[i] as f64;
                e[i] = e[i].saturating_sub(1);
                factor *= e[j] as f64;
                e[j] = e[j].saturating_sub(1);
                let rest = powers[0][e[0]] * powers[1][e[1]] * powers[2][e[2]];
                hessian[(i, j)] += c * factor * rest;
            }
        }
    }
    hessian.fill_upper_triangle_with_lower_triangle();
    hessian
}

fn power(x: f64, exponent: usize) -> f64 {
    (0..exponent).fold(1.0, |product, _| product * x)
}

/// The coefficients of (wᵀ A w)².
pub(crate) fn squared(matrix: &Matrix3<f64>) -> [f64; 15] {
    let mut coefficients = [0.0; 15];
    for index in 0..81 {
        let axes = [index % 3, index / 3 % 3, index / 9 % 3, index / 27];
        let mut exponents = [0; 3];
        axes.iter().for_each(|&axis| exponents[axis] += 1);
        let product = matrix[(axes[0], axes[1])] * matrix[(axes[2], axes[3])];
        for (c, e) in coefficients.iter_mut().zip(&QUARTIC_EXPONENTS) {
            if *e == exponents {
                *c += product;
            }
        }
    }
    coefficients
}

/// Proves that the Hessian is positive definite in every direction.
///
/// By symmetry three faces of the cube |w|∞ = 1 are enough. The Hessian is a quadratic form of w, so
/// that at m + u e₁ + v e₂ it is H(m) + u B(m, e₁) + v B(m, e₂) + u² H(e₁) + u v B(e₁, e₂) + v² H(e₂)
/// with B(a, b) = H(a + b) − H(a) − H(b): norms of these bound its change over a cell.
fn certify(coefficients: &[f64; 15]) -> Result<(), MechanicsError> {
    let axes = [0, 1, 2].map(|axis| Vector3::ith_axis(axis).into_inner());
    let at = |w: Vector3<f64>| hessian(coefficients, &w);
    let mixed = axes.map(|a| axes.map(|b| at(a + b) - at(a) - at(b)));
    let scale = axes.iter().map(|axis| at(*axis).norm()).fold(0.0, f64::max);
    // Breadth first, so that a dent is found before its rim is looked at closely.
    let mut open: VecDeque<_> = (0..3).map(|face| (face, 0.0, 0.0, 1.0)).collect();
    let mut cells = 0;
    while let Some((face, u, v, half)) = open.pop_front() {
        cells += 1;
        if cells > MAX_CELLS || half < 1e-7 {
            return Err(MechanicsError::ConvexityUndecided { cells });
        }
        let (along_u, along_v) = ((face + 1) % 3, (face + 2) % 3);
        let middle = axes[face] + u * axes[along_u] + v * axes[along_v];
        let slope = |axis: usize| -> Matrix3<f64> {
            middle.iter().zip(&mixed[axis]).map(|(m, form)| *m * form).sum()
        };
        let curvature: Matrix3<f64> = (0..3).map(|axis| 0.5 * middle[axis] * slope(axis)).sum();
        let first_order = slope(along_u).norm() + slope(along_v).norm();
        let second_order = 0.5 * mixed[along_u][along_u].norm()
            + 0.5 * mixed[along_v][along_v].norm()
            + mixed[along_u][along_v].norm();
        let change = half * first_order + half * half * second_order;
        if is_positive_definite(&(curvature - change * Matrix3::identity())) {
            continue;
        }
        if !is_positive_definite(&curvature) {
            let eigenvalue = curvature.symmetric_eigenvalues().min() / middle.norm_squared();
            if eigenvalue < -1e-12 * scale {
                let direction = middle.normalize().into();
                return Err(MechanicsError::NotConvex { direction, eigenvalue });
            }
        }
        let quarter = 0.5 * half;
        for (du, dv) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
            open.push_back((face, u + du * quarter, v + dv * quarter, quarter));
        }
    }
    Ok(())
}

/// Sylvester's criterion.
fn is_positive_definite(m: &Matrix3<f64>) -> bool {
    m[(0, 0)] > 0.0 && m[(0, 0)] * m[(1, 1)] - m[(0, 1)] * m[(1, 0)] > 0.0 && m.determinant() > 0.0
}

#[cfg(test)]
mod tests {
    use super::{Quartic, gradient, polynomial, squared};
    use crate::{Ellipsoid, LimitSurface, MechanicsError};
    use nalgebra::{Matrix3, Vector3};
    use planar::{Twist, Wrench};

    fn fourth_powers(cross_term: f64) -> [f64; 15] {
        let mut c = [0.0; 15];
        (c[0], c[10], c[14], c[3], c[5], c[12]) =
            (1.0, 1.0, 1.0, cross_term, cross_term, cross_term);
        c
    }

    #[test]
    fn a_squared_ellipsoid_is_the_ellipsoid() {
        let tilted = Matrix3::new(1.0, 0.2, 3.0, 0.2, 2.0, -4.0, 3.0, -4.0, 500.0);
        let ellipsoid = Ellipsoid::from_matrix(tilted).unwrap();
        let quartic = Quartic::from_ellipsoid(&ellipsoid).unwrap();
        let (wrench, twist) = (Wrench::new(0.5, -0.2, 0.03), Twist::new(0.01, 0.02, -0.5));
        let level = |s: &dyn LimitSurface| s.level(&wrench).unwrap();
        assert!((level(&quartic) - level(&ellipsoid)).abs() < 1e-14);
        let load = |s: &dyn LimitSurface| s.wrench(&twist).unwrap();
        assert!((load(&quartic) - load(&ellipsoid)).to_vector().norm() < 1e-10);
    }

    #[test]
    fn a_dent_is_found_and_named() {
        // At (1, 1, 0) the Hessian's block is (12 + 2k, 4k; 4k, 12 + 2k): 12 − 2k < 0 for k = 8.
        let dented = Quartic::new(fourth_powers(8.0), 0.05);
        let Err(MechanicsError::NotConvex { direction, eigenvalue }) = dented else {
            panic!("{dented:?}")
        };
        let w = Vector3::from(direction);
        assert!(eigenvalue < 0.0 && (w.norm() - 1.0).abs() < 1e-12);
        let least = super::hessian(&fourth_powers(8.0), &w).symmetric_eigenvalues().min();
        assert!((least - eigenvalue).abs() < 1e-12);
    }

    #[test]
    fn a_quartic_without_curvature_across_an_axis_is_on_the_border_of_convexity() {
        // Without cross terms the curvature across an axis is zero: a limit that cannot be proved.
        assert!(Quartic::new(fourth_powers(2.0), 0.05).is_ok());
        let edge = Quartic::new(fourth_powers(0.0), 0.05);
        assert!(matches!(edge, Err(MechanicsError::ConvexityUndecided { .. })), "{edge:?}");
        let dent = Quartic::new(fourth_powers(-1e-3), 0.05);
        assert!(matches!(dent, Err(MechanicsError::NotConvex { .. })), "{dent:?}");
    }

    #[test]
    fn dents_that_only_one_face_of_the_cube_sees_are_found() {
        for axis in 0..3 {
            let near = |side: f64| {
                let mut w = Vector3::repeat(0.5 * side);
                w[axis] = 0.5_f64.sqrt();
                w
            };
            let (a, b) = (near(1.0) * near(1.0).transpose(), near(-1.0) * near(-1.0).transpose());
            // |w|⁴ + k (a·w)²(b·w)²: with a ⊥ b of unit length dented at a and b only, if k < −2.
            let (sphere, sum, difference) =
                (squared(&Matrix3::identity()), squared(&(a + b)), squared(&(a - b)));
            let bent =
                |k: f64| std::array::from_fn(|i| sphere[i] + 0.25 * k * (sum[i] - difference[i]));
            let refused = Quartic::new(bent(-2.05), 0.05);
            assert!(matches!(refused, Err(MechanicsError::NotConvex { .. })), "{axis} {refused:?}");
            assert!(Quartic::new(bent(-1.9), 0.05).is_ok(), "{axis}");
        }
    }

    /// The smallest eigenvalue of the Hessian over a grid on the cube's faces.
    fn least_curvature(coefficients: &[f64; 15]) -> f64 {
        let at = |k: usize| k as f64 / 20.0 - 1.0;
        let on_face = |face: usize, i: usize, j: usize| {
            let mut w = Vector3::zeros();
            (w[face], w[(face + 1) % 3], w[(face + 2) % 3]) = (1.0, at(i), at(j));
            super::hessian(coefficients, &w).symmetric_eigenvalues().min()
        };
        let cells = (0..3).flat_map(|face| (0..41 * 41).map(move |k| (face, k / 41, k % 41)));
        cells.map(|(face, i, j)| on_face(face, i, j)).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn the_certificate_ends_where_the_first_dent_begins() {
        for seed in 0..16 {
            let bumpy = |size: f64| {
                let mut c = fourth_powers(2.0);
                for (k, c) in c.iter_mut().enumerate() {
                    *c += size * (2.3 * f64::from(seed) + 1.7 * k as f64).sin();
                }
                c
            };
            let (mut convex, mut dented) = (0.0, 4.0);
            while dented - convex > 0.01 * dented {
                let middle = 0.5 * (convex + dented);
                match Quartic::new(bumpy(middle), 0.05) {
                    Ok(_) => convex = middle,
                    Err(_) => dented = middle,
                }
            }
            assert!(least_curvature(&bumpy(convex)) > 0.0, "{seed}: {convex}");
            assert!(least_curvature(&bumpy(1.02 * dented)) < 0.0, "{seed}: {dented}");
        }
    }

    #[test]
    fn the_gradient_is_the_finite_difference_of_the_polynomial() {
        let c: [f64; 15] = std::array::from_fn(|k| (k as f64 * 1.7).sin());
        let w = Vector3::new(0.3, -0.8, 0.5);
        for axis in 0..3 {
            let mut step = Vector3::zeros();
            step[axis] = 1e-5;
            let slope = (polynomial(&c, &(w + step)) - polynomial(&c, &(w - step))) / 2e-5;
            assert!((slope - gradient(&c, &w)[axis]).abs() < 1e-9);
        }
    }

    #[test]
    fn bad_coefficients_are_refused() {
        let nan = Quartic::new([f64::NAN; 15], 0.05);
        assert!(matches!(nan, Err(MechanicsError::NotFinite { .. })));
        let short = Quartic::new(fourth_powers(2.0), 0.0);
        assert!(matches!(short, Err(MechanicsError::NotPositive { .. })));
    }
}
