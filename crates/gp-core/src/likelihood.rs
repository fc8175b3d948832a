//! The log marginal likelihood of an exact Gaussian process and its gradient.

use std::f64::consts::PI;

use faer::{Mat, MatRef};
use rayon::prelude::{IndexedParallelIterator, ParallelIterator};

use crate::cholesky::{factorize, invert, log_determinant};
use crate::kernel::{COLUMNS, column, column_of, copy_row};
use crate::triangle::{scratch_rows, solve_lower, solve_upper};
use crate::vector::{add_multiple, dot};
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
    /// The covariance, then its factor, then its inverse, then the slope by the covariance.
    work: Mat<f64>,
    scratch: Mat<f64>,
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
            work: Mat::zeros(n, n),
            scratch: Mat::zeros(scratch_rows(n), n),
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
        self.fill(kernel, noise_variance);
        factorize(COVARIANCE, self.work.as_mut())?;
        let (_, weights, value) = solve_residual(self.work.as_ref(), self.y, self.mean);
        invert(self.work.as_mut(), self.scratch.as_mut());
        self.contract(kernel, noise_variance, &weights, gradient);
        Ok(value)
    }

    /// Writes the lower triangles of K(X, X) and of the covariance.
    fn fill(&mut self, kernel: &dyn Kernel, noise_variance: f64) {
        let x = self.x;
        let grams = self.gram.par_col_chunks_mut(COLUMNS);
        let covariances = self.work.par_col_chunks_mut(COLUMNS);
        grams.zip(covariances).enumerate().for_each(|(block, (mut grams, mut covariances))| {
            let mut b = vec![0.0; x.ncols()];
            for k in 0..grams.ncols() {
                let j = block * COLUMNS + k;
                let gram = &mut column_of(grams.as_mut(), k)[j..];
                let covariance = &mut column_of(covariances.as_mut(), k)[j..];
                copy_row(x, j, &mut b);
                kernel.column(x.subrows(j, gram.len()), &b, gram);
                covariance.copy_from_slice(gram);
                covariance[0] += noise_variance + self.row_noise.get(j).unwrap_or(&0.0);
            }
        });
    }

    /// ½ Σᵢⱼ (αᵢ αⱼ − K⁻¹ᵢⱼ) ∂Kᵢⱼ/∂ ln θ over the lower triangle, the diagonal counted half.
    fn contract(
        &mut self,
        kernel: &dyn Kernel,
        noise_variance: f64,
        weights: &[f64],
        gradient: &mut [f64],
    ) {
        let (x, gram, n_parameters) = (self.x, &self.gram, gradient.len());
        let blocks = self.work.par_col_chunks_mut(COLUMNS).enumerate();
        let parts: Vec<Vec<f64>> = blocks
            .map(|(block, mut inverses)| {
                let mut part = vec![0.0; n_parameters];
                let (of_noise, of_kernel) = part.split_last_mut().expect("it ends with the noise");
                let mut b = vec![0.0; x.ncols()];
                for k in 0..inverses.ncols() {
                    let j = block * COLUMNS + k;
                    let slope = &mut column_of(inverses.as_mut(), k)[j..];
                    for (slope, weight) in slope.iter_mut().zip(&weights[j..]) {
                        *slope = weight * weights[j] - *slope;
                    }
                    slope[0] *= 0.5;
                    *of_noise += noise_variance * slope[0];
                    copy_row(x, j, &mut b);
                    let (rows, values) = (x.subrows(j, slope.len()), &column(gram, j)[j..]);
                    kernel.column_gradient(rows, &b, values, slope, of_kernel);
                }
                part
            })
            .collect();
        for (i, slope) in gradient.iter_mut().enumerate() {
            *slope = parts.iter().map(|part| part[i]).sum();
        }
    }
}

/// The likelihood and its gradient at the parameters of a process, in memory of its own.
pub struct Evaluator<'a> {
    kernel: &'a dyn Kernel,
    noise_variance: f64,
    likelihood: Likelihood<'a>,
    gradient: Vec<f64>,
}

impl<'a> Evaluator<'a> {
    pub(crate) fn new(
        kernel: &'a dyn Kernel,
        noise_variance: f64,
        likelihood: Likelihood<'a>,
    ) -> Self {
        let gradient = vec![0.0; kernel.parameters().len() + 1];
        Self { kernel, noise_variance, likelihood, gradient }
    }

    /// ln p(y | X) in nats; fills the gradient. O(N³), without allocating matrices.
    ///
    /// # Errors
    /// `NotPositiveDefinite`.
    pub fn evaluate(&mut self) -> Result<f64, GpError> {
        self.likelihood.evaluate(self.kernel, self.noise_variance, &mut self.gradient)
    }

    /// What `evaluate` found: by the kernel's log-parameters and, last, by ln σₙ².
    pub fn gradient(&self) -> &[f64] {
        &self.gradient
    }
}

/// The constant mean m, the weights α = K⁻¹(y − m) and ln p(y).
pub(crate) fn solve_residual(
    factor: MatRef<'_, f64>,
    y: &[f64],
    mean: Mean,
) -> (f64, Vec<f64>, f64) {
    // Offsets are taken from the first output, so that m̂ loses no digits to a far origin.
    let origin = match mean {
        Mean::Fixed(value) => value,
        Mean::Estimated => y[0],
    };
    let mut weights: Vec<f64> = y.iter().map(|y| y - origin).collect();
    let mut constant = origin;
    if mean == Mean::Estimated {
        let mut ones = vec![1.0; y.len()];
        solve_lower(factor, &mut [&mut weights, &mut ones]);
        let excess = dot(&ones, &weights) / dot(&ones, &ones);
        add_multiple(&mut weights, -excess, &ones);
        constant += excess;
    } else {
        solve_lower(factor, &mut [&mut weights]);
    }
    let quadratic = dot(&weights, &weights);
    solve_upper(factor, &mut weights);
    let normalization = y.len() as f64 * (2.0 * PI).ln();
    let value = -0.5 * (quadratic + log_determinant(factor) + normalization);
    (constant, weights, value)
}
