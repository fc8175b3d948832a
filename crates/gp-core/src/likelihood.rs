//! The log marginal likelihood of an exact Gaussian process and its gradient.

use std::f64::consts::PI;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::inverse::{inverse, inverse_scratch};
use faer::{Mat, MatRef, Par};

use crate::cholesky::{factorize, log_determinant, solve_with};
use crate::kernel::{column, column_mut, copy_row, fill_lower_gram};
use crate::{GpError, Kernel, Mean};

pub(crate) const COVARIANCE: &str = "covariance of the observations";

/// ln p(y | X, θ) for one data set and many θ; owns the matrices so that they are allocated once.
///
/// ln p = −½ rᵀ K⁻¹ r − ½ ln |K| − ½ N ln 2π, K = K(X, X) + σₙ² I, r = y − m.
/// An estimated mean m stands at its maximum-likelihood value m̂ = 1ᵀK⁻¹y / 1ᵀK⁻¹1, where the
/// likelihood is stationary in m, so that the gradient in θ needs no further term.
///
/// # Source
/// Rasmussen & Williams, Gaussian Processes for Machine Learning (2006), ch. 5.
pub(crate) struct Likelihood<'a> {
    x: MatRef<'a, f64>,
    y: &'a [f64],
    /// Known noise of each row beside the common one; empty if there is none.
    row_noise: &'a [f64],
    mean: Mean,
    gram: Mat<f64>,
    factor: Mat<f64>,
    inverse: Mat<f64>,
    memory: MemBuffer,
}

impl<'a> Likelihood<'a> {
    /// Prepares for data that have been checked.
    pub(crate) fn new(x: MatRef<'a, f64>, y: &'a [f64], row_noise: &'a [f64], mean: Mean) -> Self {
        let n = x.nrows();
        Self {
            x,
            y,
            row_noise,
            mean,
            gram: Mat::zeros(n, n),
            factor: Mat::zeros(n, n),
            inverse: Mat::zeros(n, n),
            memory: MemBuffer::new(inverse_scratch::<f64>(n, Par::Seq)),
        }
    }

    /// ln p, and its gradient by the log-parameters of the kernel and, last, ln σₙ²; O(N³).
    ///
    /// # Errors
    /// `NotPositiveDefinite`.
    pub(crate) fn evaluate(
        &mut self,
        kernel: &dyn Kernel,
        noise_variance: f64,
        gradient: &mut [f64],
    ) -> Result<f64, GpError> {
        let n = self.y.len();
        fill_lower_gram(kernel, self.x, &mut self.gram);
        for j in 0..n {
            column_mut(&mut self.factor, j)[j..].copy_from_slice(&column(&self.gram, j)[j..]);
            self.factor[(j, j)] += noise_variance;
        }
        for (j, noise) in self.row_noise.iter().enumerate() {
            self.factor[(j, j)] += noise;
        }
        factorize(COVARIANCE, self.factor.as_mut())?;
        let (_, weights, value) = solve_residual(self.factor.as_ref(), self.y, self.mean);
        inverse(
            self.inverse.as_mut(),
            self.factor.as_ref(),
            Par::Seq,
            MemStack::new(&mut self.memory),
        );
        self.contract(kernel, noise_variance, &weights, gradient);
        Ok(value)
    }

    /// ½ Σᵢⱼ (αᵢ αⱼ − K⁻¹ᵢⱼ) ∂Kᵢⱼ/∂ ln θ over the lower triangle, the diagonal counted half.
    fn contract(
        &mut self,
        kernel: &dyn Kernel,
        noise_variance: f64,
        weights: &[f64],
        gradient: &mut [f64],
    ) {
        gradient.fill(0.0);
        let (of_noise, of_kernel) = gradient.split_last_mut().expect("it ends with the noise");
        let mut b = vec![0.0; self.x.ncols()];
        for j in 0..weights.len() {
            let difference = &mut column_mut(&mut self.inverse, j)[j..];
            for (value, weight) in difference.iter_mut().zip(&weights[j..]) {
                *value = weight * weights[j] - *value;
            }
            difference[0] *= 0.5;
            *of_noise += noise_variance * difference[0];
            copy_row(self.x, j, &mut b);
            let rows = self.x.subrows(j, weights.len() - j);
            let values = &column(&self.gram, j)[j..];
            kernel.column_gradient(rows, &b, values, difference, of_kernel);
        }
    }
}

/// The constant mean m, the weights α = K⁻¹(y − m) and ln p(y).
pub(crate) fn solve_residual(
    factor: MatRef<'_, f64>,
    y: &[f64],
    mean: Mean,
) -> (f64, Vec<f64>, f64) {
    let constant = match mean {
        Mean::Fixed(value) => value,
        Mean::Estimated => {
            let mut ones = vec![1.0; y.len()];
            solve_with(factor, &mut ones);
            let total: f64 = ones.iter().sum();
            // Offsets are taken from the first output, so that m̂ loses no digits to a far origin.
            let first = y[0];
            first + ones.iter().zip(y).map(|(one, y)| one * (y - first)).sum::<f64>() / total
        }
    };
    let residual: Vec<f64> = y.iter().map(|y| y - constant).collect();
    let mut weights = residual.clone();
    solve_with(factor, &mut weights);
    let quadratic: f64 = residual.iter().zip(&weights).map(|(r, weight)| r * weight).sum();
    let normalization = y.len() as f64 * (2.0 * PI).ln();
    let value = -0.5 * (quadratic + log_determinant(factor) + normalization);
    (constant, weights, value)
}
