//! Least squares within a convex set, by the path of its barrier.

use crate::MechanicsError;
use nalgebra::{DMatrix, DVector};

/// A convex set through a function that grows without bound towards its rim.
pub(super) trait Barrier {
    /// The barrier's parameter ν: with the weight μ, the least squares end at most ν μ above their
    /// smallest value in the set.
    fn parameter(&self) -> f64;

    /// Value, gradient and Hessian of a self-concordant barrier; none outside the set.
    fn at(&self, x: &DVector<f64>) -> Option<(f64, DVector<f64>, DMatrix<f64>)>;
}

const MAX_STEPS: usize = 500;
/// How far the end may be above the smallest sum of squares, relative to that of x = 0.
const TOLERANCE: f64 = 1e-8;

/// The x within the set that makes ½|rows·x − right|² smallest, to 1e-8 of ½|right|², and the number
/// of Newton steps; `start` lies inside.
///
/// # Errors
/// `NotConverged`, and `Undetermined` where the Hessian is singular.
pub(super) fn constrained_least_squares(
    what: &'static str,
    rows: &DMatrix<f64>,
    right: &DVector<f64>,
    set: &impl Barrier,
    start: DVector<f64>,
) -> Result<(DVector<f64>, usize), MechanicsError> {
    let (gram, pull) = (rows.tr_mul(rows), rows.tr_mul(right));
    let squares = |x: &DVector<f64>| 0.5 * x.dot(&(&gram * x)) - pull.dot(x);
    let scale = 0.5 * right.norm_squared();
    let undetermined = || MechanicsError::Undetermined { what };
    let mut x = start;
    let mut weight = scale / set.parameter();
    for n_steps in 1..=MAX_STEPS {
        let (value, slope, curvature) = set.at(&x).ok_or_else(undetermined)?;
        let gradient = &gram * &x - &pull + weight * slope;
        let hessian = &gram + weight * curvature;
        let step = -hessian.cholesky().ok_or_else(undetermined)?.solve(&gradient);
        let decrement = -gradient.dot(&step);
        if decrement <= 1e-2 * weight {
            if set.parameter() * weight <= TOLERANCE * scale {
                return Ok((x, n_steps));
            }
            weight *= 0.1;
            continue;
        }
        let here = squares(&x) + weight * value;
        let falls = |share: f64| {
            let next = &x + share * &step;
            let (value, ..) = set.at(&next)?;
            (squares(&next) + weight * value <= here - 0.1 * share * decrement).then_some(next)
        };
        let halvings = (0..50).map(|k| 0.5_f64.powi(k));
        x = halvings.into_iter().find_map(falls).ok_or_else(|| not_converged(what, n_steps))?;
    }
    Err(not_converged(what, MAX_STEPS))
}

fn not_converged(what: &'static str, iterations: usize) -> MechanicsError {
    let (residual, tolerance) = (f64::INFINITY, TOLERANCE);
    MechanicsError::NotConverged { what, iterations, residual, tolerance }
}

#[cfg(test)]
mod tests {
    use super::{Barrier, constrained_least_squares};
    use nalgebra::{DMatrix, DVector, dmatrix, dvector};

    /// The quadrant of positive components.
    struct Quadrant;

    impl Barrier for Quadrant {
        fn parameter(&self) -> f64 {
            2.0
        }

        fn at(&self, x: &DVector<f64>) -> Option<(f64, DVector<f64>, DMatrix<f64>)> {
            let inverse = x.map(f64::recip);
            let curvature = DMatrix::from_diagonal(&inverse.map(|v| v * v));
            let value = -x.map(f64::ln).sum();
            (x.min() > 0.0).then(|| (value, -inverse, curvature))
        }
    }

    #[test]
    fn the_nearest_point_of_the_set_is_found_inside_and_on_the_rim() {
        let rows = dmatrix![1.0, 0.5; 0.0, 1.0];
        for (right, expected) in
            [(dvector![3.0, 2.0], dvector![2.0, 2.0]), (dvector![-1.0, 2.0], dvector![0.0, 1.2])]
        {
            let start = dvector![1.0, 1.0];
            let (x, _) =
                constrained_least_squares("a test", &rows, &right, &Quadrant, start).unwrap();
            assert!((&x - &expected).norm() < 1e-4, "{x} {expected}");
        }
    }
}
