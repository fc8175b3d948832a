//! A function of a Gaussian, as a line with what is left of it.

use nalgebra::{DMatrix, DVector};

/// f(m + R ξ) ≈ `center` + `slope` ξ + e, for standard normal ξ and a root R of the covariance.
///
/// In ξ a covariance without rank is nothing special: no inverse of it is ever taken.
#[derive(Clone, Debug)]
pub(crate) struct Linearized {
    pub(crate) center: DVector<f64>,
    pub(crate) slope: DMatrix<f64>,
    /// Covariance of e.
    pub(crate) rest: DMatrix<f64>,
}

impl Linearized {
    /// The regression of values `f` on points `ξ`, with weights of any sum.
    ///
    /// Right to second order in the moments for rules that are exact to degree two; the rest is positive
    /// semi-definite for any.
    pub(crate) fn of_points(points: &[(DVector<f64>, f64)], values: &[DVector<f64>]) -> Self {
        let (d, k) =
            (values.first().map_or(0, DVector::len), points.first().map_or(0, |p| p.0.len()));
        let total: f64 = points.iter().map(|(_, weight)| weight).sum();
        let mut center = DVector::zeros(d);
        for ((_, weight), value) in points.iter().zip(values) {
            center.axpy(weight / total, value, 1.0);
        }
        let mut slope = DMatrix::zeros(d, k);
        for ((point, weight), value) in points.iter().zip(values) {
            slope.ger(weight / total, &(value - &center), point, 1.0);
        }
        let mut rest = DMatrix::zeros(d, d);
        for ((point, weight), value) in points.iter().zip(values) {
            let off = value - &center - &slope * point;
            rest.ger(weight / total, &off, &off, 1.0);
        }
        Self { center, slope, rest }
    }

    /// The covariance of f.
    pub(crate) fn covariance(&self) -> DMatrix<f64> {
        symmetric(&self.slope * self.slope.transpose() + &self.rest)
    }

    /// The covariance of ξ − gain · f, where the f that it is corrected by has the covariance `known`
    /// beyond what ξ explains: Joseph's form, right for any gain.
    pub(crate) fn corrected(&self, gain: &DMatrix<f64>, known: &DMatrix<f64>) -> DMatrix<f64> {
        let k = gain.nrows();
        let kept = DMatrix::identity(k, k) - gain * &self.slope;
        &kept * kept.transpose() + gain * known * gain.transpose()
    }
}

/// The mean of a matrix and its transpose.
pub(crate) fn symmetric(matrix: DMatrix<f64>) -> DMatrix<f64> {
    let transposed = matrix.transpose();
    (matrix + transposed) * 0.5
}
