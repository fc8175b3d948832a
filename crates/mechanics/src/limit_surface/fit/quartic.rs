//! The convex quartic that fits wrench–twist pairs best.

use super::barrier::{Barrier, constrained_least_squares};
use super::{Fit, Scaled, WrenchTwist, scored};
use crate::limit_surface::quartic::{QUARTIC_EXPONENTS, gradient, polynomial};
use crate::{LimitSurface, MechanicsError, Patch, Quartic, UniformPressure, mesh};
use nalgebra::{DMatrix, DVector, SMatrix, Vector3};
use planar::Shape;

/// Least curvature that a fit may have, where the sphere of the mean load has 4.
const MARGIN: f64 = 0.02;
/// Fifteen coefficients, and the nine ways to write the same quartic by another Gram matrix.
const N_UNKNOWNS: usize = 24;

type Gram = SMatrix<f64, 9, 9>;

/// Fits the convex quartic with the smallest residuals.
///
/// Plain least squares if they are convex. Otherwise least squares over all quartics whose Hessian
/// form yᵀ H(w) y is a sum of squares, zᵀ Q z with z = w ⊗ y and Q positive definite: in three
/// variables those are all the convex ones. Found by an interior-point method, then certified by
/// [`Quartic::new`] independently. ρ is `length`, in m.
///
/// # Errors
/// As [`crate::fit_ellipsoid`], below 15 pairs.
///
/// # Source
/// Zhou, Paolini, Bagnell & Mason (2016), for sums of squares; Ahmadi & Parrilo (2013), "A complete
/// characterization of the gap between convexity and SOS-convexity", for their generality.
pub fn fit_quartic(pairs: &[WrenchTwist], length: f64) -> Result<Fit<Quartic>, MechanicsError> {
    let scaled = Scaled::new("a quartic", pairs, length, 15)?;
    let unit = |k: usize| -> [f64; 15] { std::array::from_fn(|i| f64::from(u8::from(i == k))) };
    let terms = |w: &Vector3<f64>| {
        let term = |k| (0.25 * polynomial(&unit(k), w), 0.25 * gradient(&unit(k), w));
        (0..QUARTIC_EXPONENTS.len()).map(term).collect::<Vec<_>>()
    };
    let (rows, right) = scaled.level_set_equations(4.0, &terms);
    let quartic = |x: &DVector<f64>| {
        Quartic::new(std::array::from_fn(|k| scaled.force.powi(-4) * x[k]), length)
    };
    let free = super::least_squares("a quartic", rows.clone(), &right)?;
    match quartic(&free) {
        Ok(surface) => return scored(surface, pairs, length, 0),
        Err(MechanicsError::NotConvex { .. } | MechanicsError::ConvexityUndecided { .. }) => {}
        Err(error) => return Err(error),
    }
    let rows = rows.resize_horizontally(N_UNKNOWNS, 0.0);
    let (what, start) = ("a fit of a quartic", SumsOfSquares::sphere());
    let (best, n_steps) =
        constrained_least_squares(what, &rows, &right, &SumsOfSquares::new(), start)?;
    scored(quartic(&best)?, pairs, length, n_steps)
}

/// Latitudes of each hemisphere at which a quartic meets the exact surface.
const MESH: usize = 4;

impl UniformPressure for Quartic {
    const NAME: &'static str = "quartic";

    /// The convex quartic that fits loads and motions of the exact surface best.
    fn over(shape: &Shape, f_max: f64) -> Result<Self, MechanicsError> {
        let exact = Patch::uniform(shape, f_max)?;
        let length = exact.characteristic_length();
        let mesh = mesh(&exact, length, MESH)?;
        let rows = mesh.wrenches.iter().zip(&mesh.normals);
        let pairs: Vec<_> = rows
            .flat_map(|(wrenches, twists)| wrenches.iter().zip(twists))
            .map(|(&wrench, &twist)| WrenchTwist { wrench, twist })
            .collect();
        Ok(fit_quartic(&pairs, length)?.surface)
    }
}

/// Quartics with Q − margin positive definite, as a cone with the barrier −log det.
struct SumsOfSquares {
    /// What each unknown adds to Q.
    parts: Vec<Gram>,
}

impl SumsOfSquares {
    fn new() -> Self {
        let mut parts: Vec<Gram> = QUARTIC_EXPONENTS.iter().map(gram_of).collect();
        for (i, j) in [(0, 1), (0, 2), (1, 2)] {
            for (k, l) in [(0, 1), (0, 2), (1, 2)] {
                // wᵢ yₖ · wⱼ yₗ = wᵢ yₗ · wⱼ yₖ
                let mut part = Gram::zeros();
                for (row, column, sign) in [((i, k), (j, l), 1.0), ((i, l), (j, k), -1.0)] {
                    part[(index(row), index(column))] += sign;
                    part[(index(column), index(row))] += sign;
                }
                parts.push(part);
            }
        }
        Self { parts }
    }

    /// H = |w|⁴, whose Hessian form is 4 |w|² |y|² + 8 (w·y)².
    fn sphere() -> DVector<f64> {
        let mut x = DVector::zeros(N_UNKNOWNS);
        for (k, c) in [(0, 1.0), (10, 1.0), (14, 1.0), (3, 2.0), (5, 2.0), (12, 2.0)] {
            x[k] = c;
        }
        for slack in [15, 19, 23] {
            x[slack] = 4.0;
        }
        x
    }
}

impl Barrier for SumsOfSquares {
    fn parameter(&self) -> f64 {
        9.0
    }

    fn at(&self, x: &DVector<f64>) -> Option<(f64, DVector<f64>, DMatrix<f64>)> {
        let sum: Gram = self.parts.iter().zip(x.iter()).map(|(part, x)| part * *x).sum();
        let factor = (sum - MARGIN * Gram::identity()).cholesky()?;
        let value = -2.0 * factor.l_dirty().diagonal().map(f64::ln).sum();
        let inverse = factor.inverse();
        let moved: Vec<Gram> = self.parts.iter().map(|part| inverse * part).collect();
        let gradient = DVector::from_fn(N_UNKNOWNS, |k, _| -moved[k].trace());
        let hessian = DMatrix::from_fn(N_UNKNOWNS, N_UNKNOWNS, |k, l| moved[k].tr_dot(&moved[l]));
        Some((value, gradient, hessian))
    }
}

/// Where wᵢ yₖ is in z.
fn index((i, k): (usize, usize)) -> usize {
    3 * i + k
}

/// The Gram matrix of a monomial's Hessian form: 12 times its symmetric tensor.
fn gram_of(exponents: &[usize; 3]) -> Gram {
    let factorial = |n: usize| (1..=n).product::<usize>() as f64;
    let entries = 24.0 / exponents.iter().map(|&n| factorial(n)).product::<f64>();
    Gram::from_fn(|row, column| {
        let mut counts = [0; 3];
        [row / 3, row % 3, column / 3, column % 3].iter().for_each(|&axis| counts[axis] += 1);
        if counts == *exponents { 12.0 / entries } else { 0.0 }
    })
}

#[cfg(test)]
mod tests {
    use super::{Gram, SumsOfSquares};
    use crate::limit_surface::quartic::hessian;
    use nalgebra::{SVector, Vector3};

    #[test]
    fn every_gram_matrix_is_that_of_the_hessian_form() {
        let parts = SumsOfSquares::new().parts;
        let x: Vec<f64> = (0..parts.len()).map(|k| (1.3 * k as f64).sin()).collect();
        let gram: Gram = parts.iter().zip(&x).map(|(part, x)| part * *x).sum();
        let coefficients: [f64; 15] = std::array::from_fn(|k| x[k]);
        let (w, y) = (Vector3::new(0.3, -0.7, 0.4), Vector3::new(-0.2, 0.5, 0.9));
        let z = SVector::<f64, 9>::from_fn(|k, _| w[k / 3] * y[k % 3]);
        let form = y.dot(&(hessian(&coefficients, &w) * y));
        assert!((z.dot(&(gram * z)) - form).abs() < 1e-14);
    }
}
