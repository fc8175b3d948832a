//! An input that is uncertain itself.

use faer::{Mat, MatRef};

use crate::GpError;
use crate::checks::{check_count, check_finite, check_outputs};
use crate::cholesky::pivoted_factor;

/// A Gaussian over inputs, N(m, S); S may be singular, or zero for an input that is known.
#[derive(Clone, Debug)]
pub struct GaussianInput {
    mean: Vec<f64>,
    covariance: Mat<f64>,
}

const COVARIANCE: &str = "covariance of the input";

impl GaussianInput {
    /// A Gaussian of D inputs with a D×D covariance, each in the unit of its input.
    ///
    /// # Errors
    /// `Empty`, `ShapeMismatch`, `NotFinite`; `NotACovariance` for a matrix that is not symmetric, or
    /// negative along some direction.
    pub fn new(mean: Vec<f64>, covariance: Mat<f64>) -> Result<Self, GpError> {
        let d = mean.len();
        if d == 0 {
            return Err(GpError::Empty { what: "mean of the input" });
        }
        check_outputs("mean of the input", &mean, d)?;
        check_count("rows of the input's covariance", d, covariance.nrows())?;
        check_count("columns of the input's covariance", d, covariance.ncols())?;
        check_finite(COVARIANCE, covariance.as_ref())?;
        // In standard deviations, so that inputs of any unit count alike.
        let unit = |i: usize| match covariance[(i, i)] {
            variance if variance > 0.0 => variance.sqrt(),
            _ => 1.0,
        };
        let scaled = Mat::from_fn(d, d, |i, j| covariance[(i, j)] / (unit(i) * unit(j)));
        let is_symmetric = (&scaled - scaled.transpose()).norm_max() <= ROUNDING;
        if !is_symmetric || pivoted_factor(COVARIANCE, scaled.as_ref()).is_err() {
            return Err(GpError::NotACovariance { what: COVARIANCE });
        }
        Ok(Self { mean, covariance })
    }

    /// The number of inputs D.
    pub fn n_inputs(&self) -> usize {
        self.mean.len()
    }

    /// m, one an input.
    pub fn mean(&self) -> &[f64] {
        &self.mean
    }

    /// S, D×D.
    pub fn covariance(&self) -> MatRef<'_, f64> {
        self.covariance.as_ref()
    }
}

/// Of entries of a correlation matrix.
const ROUNDING: f64 = 1e-10;

#[cfg(test)]
mod tests {
    use faer::Mat;

    use super::{COVARIANCE, GaussianInput};
    use crate::GpError;

    #[test]
    fn what_is_no_gaussian_is_refused() {
        let new = |mean: &[f64], entries: [[f64; 2]; 2]| {
            GaussianInput::new(mean.to_vec(), Mat::from_fn(2, 2, |i, j| entries[i][j])).map(|_| ())
        };
        let not = Err(GpError::NotACovariance { what: COVARIANCE });
        assert_eq!(new(&[0.0, 1.0], [[1.0, 2.0], [2.0, 1.0]]), not);
        assert_eq!(new(&[0.0, 1.0], [[1.0, 0.5], [0.4, 1.0]]), not);
        assert_eq!(new(&[0.0, 1.0], [[-1.0, 0.0], [0.0, 1.0]]), not);
        assert!(matches!(
            new(&[0.0], [[1.0, 0.0], [0.0, 1.0]]),
            Err(GpError::ShapeMismatch { .. })
        ));
        let infinite = new(&[0.0, f64::INFINITY], [[1.0, 0.0], [0.0, 1.0]]);
        assert!(matches!(infinite, Err(GpError::NotFinite { .. })));
        // Singular ones are Gaussians: a plane in a line, and a point.
        assert_eq!(new(&[0.0, 1.0], [[1.0, 1e-3], [1e-3, 1e-6]]), Ok(()));
        assert_eq!(new(&[0.0, 1.0], [[0.0, 0.0], [0.0, 0.0]]), Ok(()));
    }
}
