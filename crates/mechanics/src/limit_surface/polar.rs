//! From a support function to the gauge of the same body, and back.

use crate::MechanicsError;
use nalgebra::{Matrix2, Matrix3, Matrix3x2, Vector2, Vector3};

/// A convex function f, homogeneous of degree one and positive away from 0.
pub(crate) trait Homogeneous {
    /// f and its gradient at a nonzero x.
    fn value(&self, x: &Vector3<f64>) -> Result<(f64, Vector3<f64>), MechanicsError>;

    /// The second derivatives of f at a nonzero x where f is smooth.
    fn hessian(&self, x: &Vector3<f64>) -> Result<Matrix3<f64>, MechanicsError>;

    /// The relative error of f and its gradient.
    fn noise(&self) -> f64 {
        1e-14
    }
}

/// The polar f°(y) = max x·y/f(x), and a maximizer x scaled to f(x) = 1.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Polar {
    /// f°(y).
    pub(crate) value: f64,
    /// A normal at y/f°(y), with f(x) = 1.
    pub(crate) normal: Vector3<f64>,
}

/// Relative size of the gradient within the plane y·x = 1 at which the search ends, if f is exact.
const TOLERANCE: f64 = 1e-11;
const MAX_ITERATIONS: usize = 200;

/// The polar of f at a nonzero y, by Newton's method for min f(x) subject to y·x = 1.
///
/// The search starts at `start` (by default y itself) and must not pass a kink of f. It ends when
/// the gradient within the plane is below 1e-11 (or ten times f's noise) of the whole gradient, or when rounding
/// hides any further decrease of f; the value then has a relative error of about ten times that noise.
pub(crate) fn polar(
    what: &'static str,
    f: &impl Homogeneous,
    y: &Vector3<f64>,
    start: Option<Vector3<f64>>,
) -> Result<Polar, MechanicsError> {
    let size = y.norm();
    let unit = y / size;
    let plane = plane_basis(&unit);
    let mut x = start.map_or(unit, |x| x / unit.dot(&x));
    let (mut value, mut gradient) = f.value(&x)?;
    let tolerance = TOLERANCE.max(10.0 * f.noise());
    let mut residual = f64::INFINITY;
    for _ in 0..MAX_ITERATIONS {
        let slope = plane.transpose() * gradient;
        residual = slope.norm() / gradient.norm();
        if residual <= tolerance {
            return Ok(Polar { value: size / value, normal: x / value });
        }
        let step = newton_step(&(plane.transpose() * f.hessian(&x)? * plane), &slope);
        let decrement = -slope.dot(&step);
        let Some((next, next_value, next_gradient)) =
            descend(f, &x, value, &(plane * step), decrement)?
        else {
            if decrement <= 10.0 * f.noise() * value {
                return Ok(Polar { value: size / value, normal: x / value });
            }
            break;
        };
        (x, value, gradient) = (next, next_value, next_gradient);
    }
    let iterations = MAX_ITERATIONS;
    Err(MechanicsError::NotConverged { what, iterations, residual, tolerance })
}

/// Two unit vectors that span the plane normal to a unit vector.
pub(crate) fn plane_basis(unit: &Vector3<f64>) -> Matrix3x2<f64> {
    let mut axis = Vector3::zeros();
    axis[unit.iamin()] = 1.0;
    let first = unit.cross(&axis).normalize();
    Matrix3x2::from_columns(&[first, unit.cross(&first)])
}

type Point = (Vector3<f64>, f64, Vector3<f64>);

/// Halves the step until f falls as it should (Armijo).
///
/// Where the change of f drowns in rounding, a shrinking slope decides instead.
fn descend(
    f: &impl Homogeneous,
    x: &Vector3<f64>,
    value: f64,
    step: &Vector3<f64>,
    decrement: f64,
) -> Result<Option<Point>, MechanicsError> {
    let limit = 4.0 * x.norm() / step.norm();
    let mut fraction = limit.min(1.0);
    for _ in 0..60 {
        let next = x + fraction * step;
        let (next_value, gradient) = f.value(&next)?;
        if next_value <= value - 1e-4 * fraction * decrement {
            return Ok(Some((next, next_value, gradient)));
        }
        let hidden =
            decrement <= 100.0 * f.noise() * value && next_value <= value * (1.0 + f.noise());
        if hidden && gradient.dot(step).abs() <= 0.5 * decrement {
            return Ok(Some((next, next_value, gradient)));
        }
        fraction *= 0.5;
    }
    Ok(None)
}

/// −H⁻¹ g, with H shifted where it is not safely positive definite.
fn newton_step(hessian: &Matrix2<f64>, slope: &Vector2<f64>) -> Vector2<f64> {
    let trace = hessian.trace().max(f64::MIN_POSITIVE);
    let floor = 1e-12 * trace;
    let half_gap = (0.5 * (hessian[(0, 0)] - hessian[(1, 1)])).hypot(hessian[(0, 1)]);
    let smallest = 0.5 * hessian.trace() - half_gap;
    let shift = (floor - smallest).max(0.0);
    let shifted = hessian + shift * Matrix2::identity();
    let determinant = shifted.determinant();
    let step = Vector2::new(
        shifted[(0, 1)] * slope.y - shifted[(1, 1)] * slope.x,
        shifted[(0, 1)] * slope.x - shifted[(0, 0)] * slope.y,
    ) / determinant;
    let usable = step.iter().all(|x| x.is_finite()) && step.dot(slope) < 0.0;
    if usable { step } else { -slope / trace.max(slope.norm()) }
}
