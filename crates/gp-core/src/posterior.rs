//! The trait of everything that predicts a function with its uncertainty.

use faer::{Mat, MatRef};

use crate::checks::check_count;
use crate::{GpError, JointGaussian, Workspace};

/// A Gaussian belief about a function f after data have been seen.
///
/// `x_star` is M×D, one input a row. f is the function without noise; an observation is f plus
/// noise. All variances are in the squared unit of the output.
pub trait Posterior: Send + Sync {
    /// The number of input coordinates D.
    fn n_inputs(&self) -> usize;

    /// The posterior mean of f at each row; skips all work for the variance.
    ///
    /// # Errors
    /// `Empty`, `ShapeMismatch` or `NotFinite` if `x_star` is not a finite M×D matrix.
    fn predict_mean(&self, x_star: MatRef<'_, f64>) -> Result<Vec<f64>, GpError>;

    /// The posterior mean and variance of f at each row.
    ///
    /// # Errors
    /// As `predict_mean`.
    fn predict(&self, x_star: MatRef<'_, f64>) -> Result<(Vec<f64>, Vec<f64>), GpError>;

    /// As `predict` on the calling thread, in memory that is there: for many small calls, none of
    /// which should allocate matrices.
    ///
    /// - `mean`, `variance`: one a row, overwritten.
    ///
    /// # Errors
    /// As `predict_mean`; `ShapeMismatch` if there is not one mean and one variance a row.
    fn predict_into(
        &self,
        x_star: MatRef<'_, f64>,
        _workspace: &mut Workspace,
        mean: &mut [f64],
        variance: &mut [f64],
    ) -> Result<(), GpError> {
        check_count("means", x_star.nrows(), mean.len())?;
        check_count("variances", x_star.nrows(), variance.len())?;
        let predicted = self.predict(x_star)?;
        mean.copy_from_slice(&predicted.0);
        variance.copy_from_slice(&predicted.1);
        Ok(())
    }

    /// The posterior mean and the full covariance of f at all rows together.
    ///
    /// # Errors
    /// As `predict_mean`.
    fn predict_joint(&self, x_star: MatRef<'_, f64>) -> Result<JointGaussian, GpError>;

    /// The variance of the noise on an observation at each row.
    ///
    /// # Errors
    /// As `predict_mean`.
    fn predict_noise(&self, x_star: MatRef<'_, f64>) -> Result<Vec<f64>, GpError>;

    /// The mean and variance of an observation at each row: those of f, plus the noise.
    ///
    /// # Errors
    /// As `predict_mean`.
    fn predict_observation(
        &self,
        x_star: MatRef<'_, f64>,
    ) -> Result<(Vec<f64>, Vec<f64>), GpError> {
        let (mean, mut variance) = self.predict(x_star)?;
        let noise = self.predict_noise(x_star)?;
        variance.iter_mut().zip(&noise).for_each(|(variance, noise)| *variance += noise);
        Ok((mean, variance))
    }

    /// Draws of f at all rows together, M×`n_samples`, one draw a column.
    ///
    /// # Errors
    /// As `predict_mean`; `NotPositiveDefinite` if rounding spoilt the covariance.
    fn sample(
        &self,
        x_star: MatRef<'_, f64>,
        n_samples: usize,
        seed: u64,
    ) -> Result<Mat<f64>, GpError> {
        self.predict_joint(x_star)?.sample(n_samples, seed)
    }
}
