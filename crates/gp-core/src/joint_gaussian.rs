//! A Gaussian over the values of a function at several inputs.

use faer::{Mat, MatRef};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use crate::checks::{check_count, check_finite, check_outputs};
use crate::cholesky::pivoted_factor;
use crate::{GpError, Kernel, gram};

/// N(mean, covariance) over M function values; the covariance may be singular.
#[derive(Clone, Debug)]
pub struct JointGaussian {
    mean: Vec<f64>,
    covariance: Mat<f64>,
}

impl JointGaussian {
    /// A Gaussian with a symmetric, positive semi-definite M×M covariance.
    ///
    /// # Errors
    /// `Empty`, `ShapeMismatch` or `NotFinite` for arguments that do not fit together.
    pub fn new(mean: Vec<f64>, covariance: Mat<f64>) -> Result<Self, GpError> {
        if mean.is_empty() {
            return Err(GpError::Empty { what: "mean" });
        }
        check_outputs("mean", &mean, mean.len())?;
        check_count("rows of the covariance", mean.len(), covariance.nrows())?;
        check_count("columns of the covariance", mean.len(), covariance.ncols())?;
        check_finite("covariance", covariance.as_ref())?;
        Ok(Self { mean, covariance })
    }

    /// The prior of a kernel at the rows of `x`, with mean 0.
    ///
    /// # Errors
    /// `Empty`, `ShapeMismatch` or `NotFinite` if `x` is not a finite M×D matrix.
    pub fn prior(kernel: &dyn Kernel, x: MatRef<'_, f64>) -> Result<Self, GpError> {
        Self::new(vec![0.0; x.nrows().max(1)], gram(kernel, x)?)
    }

    /// The mean of each value.
    pub fn mean(&self) -> &[f64] {
        &self.mean
    }

    /// The covariance of the values, M×M.
    pub fn covariance(&self) -> MatRef<'_, f64> {
        self.covariance.as_ref()
    }

    /// Draws, M×`n_samples`, one a column; the same seed gives the same draws, more of them
    /// beginning with the same ones.
    ///
    /// A factorisation with pivoting takes a singular covariance as it is, without jitter;
    /// directions whose variance is rounding are left out.
    ///
    /// # Errors
    /// `NotPositiveDefinite` if the covariance has a negative direction beyond rounding.
    pub fn sample(&self, n_samples: usize, seed: u64) -> Result<Mat<f64>, GpError> {
        let factor = pivoted_factor("joint covariance", self.covariance.as_ref())?;
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut samples = Mat::zeros(self.mean.len(), n_samples);
        for j in 0..n_samples {
            let normal: Vec<f64> = self.mean.iter().map(|_| rng.sample(StandardNormal)).collect();
            for (i, mean) in self.mean.iter().enumerate() {
                let deviation: f64 = (0..factor.ncols()).map(|k| factor[(i, k)] * normal[k]).sum();
                samples[(i, j)] = mean + deviation;
            }
        }
        Ok(samples)
    }
}
