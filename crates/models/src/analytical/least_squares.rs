//! Nonlinear least squares in a few parameters, by Levenberg and Marquardt's method.

use nalgebra::{DMatrix, DVector};

use crate::ModelError;

/// Where a fit ended.
#[derive(Clone, Debug)]
pub(crate) struct Minimum {
    pub parameters: Vec<f64>,
    /// s² (JᵀJ)⁻¹, the covariance of the parameters, with s² the mean squared residual.
    pub covariance: DMatrix<f64>,
    pub iterations: usize,
    /// Largest cosine between the residual and a column of J: 0 at a minimum.
    pub gradient: f64,
}

/// Minimises |r(x)|² from `start`; steps are of relative size, so parameters should be of order 1.
///
/// J comes from central differences over ± `difference`. It has converged when the largest cosine between the residual
/// and a column of J is below 1e-9, or when no step above 1e-9 lowers the sum of squares; after a hundred steps
/// also where the minimum is within a thousandth of a standard error, for beside kinks steps get ever shorter.
///
/// # Errors
/// Those of `residuals` at an accepted point; `Undetermined` if a parameter has no influence, or
/// none of its own; `NotConverged`.
pub(crate) fn least_squares(
    names: &[&'static str],
    start: Vec<f64>,
    difference: f64,
    residuals: impl Fn(&[f64]) -> Result<DVector<f64>, ModelError>,
) -> Result<Minimum, ModelError> {
    let mut x = start;
    let mut r = residuals(&x)?;
    let mut damping = 1e-3;
    let mut iterations = 0;
    loop {
        let j = jacobian(&x, r.len(), difference, &residuals)?;
        let normal = j.transpose() * &j;
        let slope = j.transpose() * &r;
        let gradient = largest_cosine(names, &normal, &slope, r.norm())?;
        let is_last = iterations == MAX_ITERATIONS;
        let n = r.len() as f64;
        if is_last && gradient * n.sqrt() > CLOSE {
            let what = "the parameters";
            return Err(ModelError::NotConverged { what, iterations, gradient });
        }
        let step = match is_last || gradient < GRADIENT_TOLERANCE {
            true => None,
            false => descend(&normal, &slope, &x, &r, &mut damping, &residuals)?,
        };
        let Some((next, next_r)) = step else {
            let covariance = parameter_covariance(names, normal, &r)?;
            return Ok(Minimum { parameters: x, covariance, iterations, gradient });
        };
        (x, r) = (next, next_r);
        iterations += 1;
    }
}

const MAX_ITERATIONS: usize = 100;
const GRADIENT_TOLERANCE: f64 = 1e-9;
/// Of a standard error: closer to the minimum no estimate has to be.
const CLOSE: f64 = 1e-3;
/// A step below this changes a parameter of order 1 by less than its derivative is known.
const STEP_TOLERANCE: f64 = 1e-9;
/// For smooth residuals of parameters of order 1.
pub(crate) const SMALL: f64 = 1e-5;

fn jacobian(
    x: &[f64],
    n: usize,
    difference: f64,
    residuals: &impl Fn(&[f64]) -> Result<DVector<f64>, ModelError>,
) -> Result<DMatrix<f64>, ModelError> {
    let mut j = DMatrix::zeros(n, x.len());
    for k in 0..x.len() {
        let at = |offset: f64| {
            let mut x = x.to_vec();
            x[k] += offset;
            residuals(&x)
        };
        j.set_column(k, &((at(difference)? - at(-difference)?) / (2.0 * difference)));
    }
    Ok(j)
}

/// |Jₖᵀ r| / (|Jₖ| |r|), the largest over the parameters; 0 where the residual is.
fn largest_cosine(
    names: &[&'static str],
    normal: &DMatrix<f64>,
    slope: &DVector<f64>,
    residual: f64,
) -> Result<f64, ModelError> {
    let mut largest: f64 = 0.0;
    for (k, &parameter) in names.iter().enumerate() {
        let influence = normal[(k, k)].sqrt();
        if influence <= 1e-9 {
            return Err(ModelError::Undetermined { parameter });
        }
        if residual > 1e-9 {
            largest = largest.max(slope[k].abs() / (influence * residual));
        }
    }
    Ok(largest)
}

/// Where a step leads, and the residuals there.
type Descent = (Vec<f64>, DVector<f64>);

/// A damped Gauss–Newton step that lowers the sum of squares; `None` if only a step too small to
/// matter would.
fn descend(
    normal: &DMatrix<f64>,
    slope: &DVector<f64>,
    x: &[f64],
    r: &DVector<f64>,
    damping: &mut f64,
    residuals: &impl Fn(&[f64]) -> Result<DVector<f64>, ModelError>,
) -> Result<Option<Descent>, ModelError> {
    loop {
        let mut damped = normal.clone();
        for k in 0..x.len() {
            damped[(k, k)] *= 1.0 + *damping;
        }
        if let Some(factor) = damped.cholesky() {
            let step = factor.solve(slope);
            if step.amax() < STEP_TOLERANCE {
                return Ok(None);
            }
            let next: Vec<f64> = x.iter().zip(step.iter()).map(|(x, step)| x - step).collect();
            let next_r = residuals(&next)?;
            if next_r.norm_squared() < r.norm_squared() {
                *damping = (*damping / 10.0).max(1e-12);
                return Ok(Some((next, next_r)));
            }
        }
        *damping *= 10.0;
        if *damping > 1e15 {
            return Ok(None);
        }
    }
}

fn parameter_covariance(
    names: &[&'static str],
    normal: DMatrix<f64>,
    r: &DVector<f64>,
) -> Result<DMatrix<f64>, ModelError> {
    let spare = r.len().saturating_sub(names.len()).max(1);
    let inverse = normal.cholesky().ok_or(ModelError::Undetermined { parameter: names[0] })?;
    Ok(inverse.inverse() * (r.norm_squared() / spare as f64))
}

#[cfg(test)]
mod tests {
    use super::{SMALL, least_squares};
    use crate::ModelError;
    use nalgebra::DVector;

    #[test]
    fn a_line_has_its_textbook_estimate_and_standard_errors() {
        let (t, y) = ([0.0, 1.0, 2.0, 3.0], [1.0, 3.0, 2.0, 5.0]);
        let fit = least_squares(&["a", "b"], vec![0.0, 0.0], SMALL, |x| {
            Ok(DVector::from_iterator(4, t.iter().zip(&y).map(|(t, y)| x[0] + x[1] * t - y)))
        })
        .unwrap();
        // By hand: b = 5.5/5, a = 2.75 − 1.5 b, s² = 2.7/2, var b = s²/5, var a = s² (1/4 + 1.5²/5).
        assert!((fit.parameters[1] - 1.1).abs() < 1e-8 && (fit.parameters[0] - 1.1).abs() < 1e-8);
        assert!((fit.covariance[(1, 1)] - 0.27).abs() < 1e-6);
        assert!((fit.covariance[(0, 0)] - 0.945).abs() < 1e-6);
    }

    #[test]
    fn a_curved_valley_is_followed_to_its_end() {
        let fit = least_squares(&["x", "y"], vec![-1.2, 1.0], SMALL, |x| {
            Ok(DVector::from_vec(vec![10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0], 0.0]))
        })
        .unwrap();
        assert!(fit.parameters.iter().all(|x| (x - 1.0).abs() < 1e-6));
        assert!(fit.iterations > 1);
    }

    #[test]
    fn a_search_that_is_still_far_after_a_hundred_steps_is_refused() {
        let fit = least_squares(&["x", "y"], vec![-1.2, 1.0], SMALL, |x| {
            Ok(DVector::from_vec(vec![1e2 * (x[1] - x[0] * x[0]), 1.0 - x[0], 0.0]))
        });
        assert!(matches!(fit, Err(ModelError::NotConverged { iterations: 100, .. })), "{fit:?}");
    }

    #[test]
    fn a_parameter_without_influence_is_named() {
        let fit = least_squares(&["seen", "unseen"], vec![0.5, 0.5], SMALL, |x| {
            Ok(DVector::from_vec(vec![x[0] - 1.0, x[0] + 2.0, 1.0]))
        });
        assert!(matches!(fit, Err(ModelError::Undetermined { parameter: "unseen" })));
    }
}
