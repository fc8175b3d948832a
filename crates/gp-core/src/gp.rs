//! The exact Gaussian process with a constant mean and Gaussian noise.

use std::sync::Arc;

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};
use rayon::prelude::{IndexedParallelIterator, ParallelIterator, ParallelSliceMut};
use serde::{Deserialize, Serialize};

use crate::checks::{
    check_distinct_rows, check_inputs, check_not_negative, check_outputs, check_positive,
};
use crate::cholesky::Cholesky;
use crate::kernel::{column, column_mut, copy_row, fill_cross, fill_lower_gram, mirror_lower};
use crate::likelihood::{COVARIANCE, Likelihood, solve_residual};
use crate::vector::dot;
use crate::{GpError, JointGaussian, Kernel, LeaveOneOut, Posterior};

/// A Gaussian process conditioned on data: y = f(x) + noise, f ~ GP(m, k), noise ~ N(0, σₙ²).
///
/// - f mean: m + k*ᵀ (K + σₙ² I)⁻¹ (y − m), in O(N) an input.
/// - f variance: k** − k*ᵀ (K + σₙ² I)⁻¹ k*, in O(N²) an input.
///
/// Hyperparameters, the mean m among them, are taken as known: their own uncertainty is not part
/// of the variance, which therefore never exceeds the prior's.
///
/// # Source
/// Rasmussen & Williams, Gaussian Processes for Machine Learning (2006), ch. 2; the thesis, eq. 3.10.
#[derive(Clone, Debug)]
pub struct Gp {
    kernel: Arc<dyn Kernel>,
    x: Mat<f64>,
    y: Vec<f64>,
    noise_variance: f64,
    mean: Mean,
    constant: f64,
    cholesky: Cholesky,
    weights: Vec<f64>,
    log_marginal_likelihood: f64,
}

/// The constant mean of a Gaussian process.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Mean {
    /// A hyperparameter at its maximum-likelihood value, which is the generalised-least-squares
    /// estimate 1ᵀK⁻¹y / 1ᵀK⁻¹1.
    #[default]
    Estimated,
    /// A known value, in the unit of the output.
    Fixed(f64),
}

impl Gp {
    /// Conditions a kernel with known parameters on data, with an estimated constant mean; O(N³).
    ///
    /// - `x`: inputs, N×D; a single row is enough.
    /// - `y`: outputs, N.
    /// - `noise_variance`: of an observation, in the squared unit of the output; 0 interpolates.
    ///
    /// # Errors
    /// `Empty`, `ShapeMismatch`, `NotFinite`, `Negative`; `DuplicateRows` for equal inputs without
    /// noise; `NotPositiveDefinite` if the covariance is singular to working precision.
    pub fn fit(
        kernel: impl Kernel + 'static,
        x: MatRef<'_, f64>,
        y: &[f64],
        noise_variance: f64,
    ) -> Result<Self, GpError> {
        Self::fit_with_mean(kernel, x, y, noise_variance, Mean::Estimated)
    }

    /// As `fit`, with a choice of the mean.
    ///
    /// # Errors
    /// As `fit`.
    pub fn fit_with_mean(
        kernel: impl Kernel + 'static,
        x: MatRef<'_, f64>,
        y: &[f64],
        noise_variance: f64,
        mean: Mean,
    ) -> Result<Self, GpError> {
        Self::condition(Arc::new(kernel), x, y, noise_variance, mean)
    }

    pub(crate) fn condition(
        kernel: Arc<dyn Kernel>,
        x: MatRef<'_, f64>,
        y: &[f64],
        noise_variance: f64,
        mean: Mean,
    ) -> Result<Self, GpError> {
        check_inputs("inputs", x, kernel.n_inputs())?;
        check_outputs("outputs", y, x.nrows())?;
        check_not_negative("noise variance", noise_variance)?;
        if let Mean::Fixed(value) = mean {
            check_outputs("mean", &[value], 1)?;
        }
        if noise_variance == 0.0 {
            check_distinct_rows(x)?;
        }
        let x = x.to_owned();
        let mut matrix = Mat::zeros(y.len(), y.len());
        fill_lower_gram(&*kernel, x.as_ref(), &mut matrix);
        for i in 0..y.len() {
            matrix[(i, i)] += noise_variance;
        }
        let cholesky = Cholesky::new(COVARIANCE, matrix)?;
        let (constant, weights, log_marginal_likelihood) =
            solve_residual(cholesky.factor(), y, mean);
        let y = y.to_vec();
        Ok(Self {
            kernel,
            x,
            y,
            noise_variance,
            mean,
            constant,
            cholesky,
            weights,
            log_marginal_likelihood,
        })
    }

    /// The kernel, with its parameters in the user's units.
    pub fn kernel(&self) -> &dyn Kernel {
        &*self.kernel
    }

    /// The variance of the noise on an observation, in the squared unit of the output.
    pub fn noise_variance(&self) -> f64 {
        self.noise_variance
    }

    /// The constant mean m, in the unit of the output.
    pub fn mean(&self) -> f64 {
        self.constant
    }

    /// Whether the mean was estimated or given.
    pub fn mean_choice(&self) -> Mean {
        self.mean
    }

    /// The training inputs, N×D.
    pub fn inputs(&self) -> MatRef<'_, f64> {
        self.x.as_ref()
    }

    /// The training outputs, N.
    pub fn outputs(&self) -> &[f64] {
        &self.y
    }

    /// ln p(y | X), the log density of the outputs in the user's units, in nats.
    ///
    /// Outputs in a unit s times smaller lower it by N ln s (the Jacobian of that change).
    pub fn log_marginal_likelihood(&self) -> f64 {
        self.log_marginal_likelihood
    }

    /// ∂ ln p(y | X)/∂ ln θ for the kernel's parameters and, last, the noise variance; O(N³).
    ///
    /// # Errors
    /// `NotPositive` if the noise variance is 0, which has no logarithm.
    pub fn log_marginal_likelihood_gradient(&self) -> Result<Vec<f64>, GpError> {
        check_positive("noise variance", self.noise_variance)?;
        let mut gradient = vec![0.0; self.kernel.parameters().len() + 1];
        Likelihood::new(self.x.as_ref(), &self.y, self.mean).evaluate(
            &*self.kernel,
            self.noise_variance,
            &mut gradient,
        )?;
        Ok(gradient)
    }

    /// The prediction of every training row from all the others, in closed form; O(N³).
    pub fn leave_one_out(&self) -> LeaveOneOut {
        LeaveOneOut::new(&self.y, &self.weights, &self.cholesky.inverse_diagonal())
    }

    /// The gradient of the posterior mean by the inputs, M×D, one row an input.
    ///
    /// # Errors
    /// `Empty`, `ShapeMismatch` or `NotFinite` if `x_star` is not a finite M×D matrix.
    pub fn mean_gradient(&self, x_star: MatRef<'_, f64>) -> Result<Mat<f64>, GpError> {
        check_inputs("inputs", x_star, self.n_inputs())?;
        let n_inputs = self.n_inputs();
        let (mut a, mut b) = (vec![0.0; n_inputs], vec![0.0; n_inputs]);
        let mut slope = vec![0.0; n_inputs];
        let mut gradient = Mat::zeros(x_star.nrows(), n_inputs);
        for i in 0..x_star.nrows() {
            copy_row(x_star, i, &mut a);
            for (j, weight) in self.weights.iter().enumerate() {
                copy_row(self.x.as_ref(), j, &mut b);
                self.kernel.input_gradient(&a, &b, &mut slope);
                for (d, slope) in slope.iter().enumerate() {
                    gradient[(i, d)] += weight * slope;
                }
            }
        }
        Ok(gradient)
    }

    /// Mean and variance for the rows of a block, which shares one triangular solve.
    fn predict_block(&self, x_star: MatRef<'_, f64>, mean: &mut [f64], variance: &mut [f64]) {
        let mut cross = Mat::zeros(self.y.len(), x_star.nrows());
        fill_cross(&*self.kernel, self.x.as_ref(), x_star, &mut cross);
        for (j, mean) in mean.iter_mut().enumerate() {
            *mean = self.constant + dot(column(&cross, j), &self.weights);
        }
        self.cholesky.solve_lower(cross.as_mut());
        let mut row = vec![0.0; x_star.ncols()];
        for (j, variance) in variance.iter_mut().enumerate() {
            copy_row(x_star, j, &mut row);
            let explained = dot(column(&cross, j), column(&cross, j));
            // Rounding alone can make the difference of two nearly equal variances negative.
            *variance = (self.kernel.value(&row, &row) - explained).max(0.0);
        }
    }
}

impl Posterior for Gp {
    fn n_inputs(&self) -> usize {
        self.kernel.n_inputs()
    }

    fn predict_mean(&self, x_star: MatRef<'_, f64>) -> Result<Vec<f64>, GpError> {
        check_inputs("inputs", x_star, self.n_inputs())?;
        let mut mean = vec![0.0; x_star.nrows()];
        mean.par_chunks_mut(BLOCK).enumerate().for_each(|(block, mean)| {
            let mut values = vec![0.0; self.y.len()];
            let mut row = vec![0.0; x_star.ncols()];
            for (j, mean) in mean.iter_mut().enumerate() {
                copy_row(x_star, block * BLOCK + j, &mut row);
                self.kernel.column(self.x.as_ref(), &row, &mut values);
                *mean = self.constant + dot(&values, &self.weights);
            }
        });
        Ok(mean)
    }

    fn predict(&self, x_star: MatRef<'_, f64>) -> Result<(Vec<f64>, Vec<f64>), GpError> {
        check_inputs("inputs", x_star, self.n_inputs())?;
        let mut mean = vec![0.0; x_star.nrows()];
        let mut variance = vec![0.0; x_star.nrows()];
        mean.par_chunks_mut(BLOCK).zip(variance.par_chunks_mut(BLOCK)).enumerate().for_each(
            |(block, (mean, variance))| {
                let rows = x_star.subrows(block * BLOCK, mean.len());
                self.predict_block(rows, mean, variance);
            },
        );
        Ok((mean, variance))
    }

    fn predict_joint(&self, x_star: MatRef<'_, f64>) -> Result<JointGaussian, GpError> {
        let mean = self.predict_mean(x_star)?;
        let mut cross = Mat::zeros(self.y.len(), x_star.nrows());
        fill_cross(&*self.kernel, self.x.as_ref(), x_star, &mut cross);
        self.cholesky.solve_lower(cross.as_mut());
        let mut covariance = Mat::zeros(x_star.nrows(), x_star.nrows());
        fill_lower_gram(&*self.kernel, x_star, &mut covariance);
        matmul(covariance.as_mut(), Accum::Add, cross.transpose(), &cross, -1.0, Par::Seq);
        for j in 0..covariance.ncols() {
            let diagonal = &mut column_mut(&mut covariance, j)[j];
            *diagonal = diagonal.max(0.0);
        }
        mirror_lower(&mut covariance);
        JointGaussian::new(mean, covariance)
    }

    fn predict_noise(&self, x_star: MatRef<'_, f64>) -> Result<Vec<f64>, GpError> {
        check_inputs("inputs", x_star, self.n_inputs())?;
        Ok(vec![self.noise_variance; x_star.nrows()])
    }
}

/// Inputs predicted together; the results do not depend on who computes which block.
const BLOCK: usize = 64;
