//! The log marginal likelihood of an exact Gaussian process and its gradient.

use faer::{Mat, MatMut, MatRef};
use rayon::prelude::{IndexedParallelIterator, ParallelIterator};

use crate::cholesky::{factorize, invert};
use crate::factor::COVARIANCE;
use crate::kernel::{COLUMNS, column, column_of, copy_row, fill_lower_gram};
use crate::mean::{Deviation, Residual};
use crate::noise::Noise;
use crate::shared_likelihood::SharedLikelihood;
use crate::triangle::scratch_rows;
use crate::{GpError, Kernel, Mean};

/// ln p(y | X, θ) for one data set and many θ; owns the matrices so that they are allocated once.
///
/// ln p = −½ rᵀ K⁻¹ r − ½ ln |K| − ½ N ln 2π, K = K(X, X) + σₙ² I, r = y − m. A learnt mean is
/// integrated out (see [`Residual::solve`]), after which P = K⁻¹ − Σ w wᵀ over its deviations stands
/// wherever the inverse stood.
///
/// # Source
/// Rasmussen & Williams, Gaussian Processes for Machine Learning (2006), ch. 5.
pub(crate) struct Likelihood<'a> {
    x: MatRef<'a, f64>,
    y: &'a [f64],
    mean: Mean,
    gram: Mat<f64>,
    /// The covariance, then its factor, then its inverse, then the slope by the covariance.
    work: Mat<f64>,
    scratch: Mat<f64>,
    /// For outputs at the same inputs, in place of the matrices.
    shared: SharedLikelihood,
}

impl<'a> Likelihood<'a> {
    /// Prepares for data that have been checked.
    pub(crate) fn new(x: MatRef<'a, f64>, y: &'a [f64], mean: Mean) -> Self {
        let (gram, work, scratch) = (Mat::new(), Mat::new(), Mat::new());
        Self { x, y, mean, gram, work, scratch, shared: SharedLikelihood::new() }
    }

    /// Makes the matrices where they are not there yet.
    fn reserve(&mut self) {
        let n = self.n_rows();
        if self.gram.nrows() < n {
            self.gram = Mat::zeros(n, n);
            self.work = Mat::zeros(n, n);
            self.scratch = Mat::zeros(scratch_rows(n), n);
        }
    }

    pub(crate) fn n_rows(&self) -> usize {
        self.y.len()
    }

    /// ln p, and its gradient by the log-parameters of the kernel and, last, ln σₙ²; O(N³), and P² times
    /// less where the rows are P outputs at the same inputs.
    ///
    /// # Errors
    /// `NotPositiveDefinite`.
    pub(crate) fn evaluate(
        &mut self,
        kernel: &dyn Kernel,
        noise: Noise<'_>,
        gradient: &mut [f64],
    ) -> Result<f64, GpError> {
        let (x, y, mean) = (self.x, self.y, self.mean);
        if let Some(shared) = self.shared.evaluate(kernel, (x, y, mean), noise, gradient) {
            return shared;
        }
        self.fill(kernel, noise);
        let residual = self.solve()?;
        self.contract(kernel, noise.common, &residual.weights, gradient);
        Ok(residual.log_likelihood)
    }

    /// Writes the lower triangles of K(X, X) and of the covariance, each column while it is near.
    fn fill(&mut self, kernel: &dyn Kernel, noise: Noise<'_>) {
        self.reserve();
        let x = self.x;
        let grams = self.gram.par_col_chunks_mut(COLUMNS);
        let covariances = self.work.par_col_chunks_mut(COLUMNS);
        grams.zip(covariances).enumerate().for_each(|(block, (mut grams, mut covariances))| {
            let mut b = vec![0.0; x.ncols()];
            for k in 0..grams.ncols() {
                let j = block * COLUMNS + k;
                let gram = &mut column_of(grams.as_mut(), k)[j..];
                copy_row(x, j, &mut b);
                kernel.column(x.subrows(j, gram.len()), &b, gram);
                cover_column(gram, covariances.as_mut(), k, j, noise);
            }
        });
    }

    /// Writes the lower triangle of K(X, X).
    pub(crate) fn fill_gram(&mut self, kernel: &dyn Kernel) {
        self.reserve();
        fill_lower_gram(kernel, self.x, &mut self.gram);
    }

    /// Writes the lower triangle of the covariance for the K(X, X) that is there.
    pub(crate) fn cover(&mut self, noise: Noise<'_>) {
        for j in 0..self.y.len() {
            cover_column(&column(&self.gram, j)[j..], self.work.as_mut(), j, j, noise);
        }
    }

    /// Replaces the covariance by its inverse, less what a learnt mean may explain.
    ///
    /// # Errors
    /// `NotPositiveDefinite`.
    pub(crate) fn solve(&mut self) -> Result<Residual, GpError> {
        factorize(COVARIANCE, self.work.as_mut())?;
        let residual = Residual::solve(&self.work.as_ref(), self.x, self.y, self.mean)?;
        invert(self.work.as_mut(), self.scratch.as_mut());
        Deviation::project(&residual.deviations, &mut self.work);
        Ok(residual)
    }

    /// Entry i of the inverse's diagonal.
    pub(crate) fn inverse_entry(&self, i: usize) -> f64 {
        self.work[(i, i)]
    }

    /// ½ Σᵢⱼ (αᵢ αⱼ − Pᵢⱼ) ∂Kᵢⱼ/∂ ln θ over the lower triangle, the diagonal counted half; spoils
    /// the inverse.
    pub(crate) fn contract(
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
                    kernel.column_gradient(rows, &b, values, slope, of_kernel, &mut []);
                }
                part
            })
            .collect();
        for (i, slope) in gradient.iter_mut().enumerate() {
            *slope = parts.iter().map(|part| part[i]).sum();
        }
    }
}

/// Column `k` of `covariances`, which is column `j` of all, from its diagonal on.
fn cover_column(gram: &[f64], covariances: MatMut<'_, f64>, k: usize, j: usize, noise: Noise<'_>) {
    let covariance = &mut column_of(covariances, k)[j..];
    covariance.copy_from_slice(gram);
    covariance[0] += noise.of_row(j);
}

/// The likelihood and its gradient at the parameters of a process, in memory of its own.
pub struct Evaluator<'a> {
    kernel: &'a dyn Kernel,
    noise: Noise<'a>,
    likelihood: Likelihood<'a>,
    gradient: Vec<f64>,
}

impl<'a> Evaluator<'a> {
    pub(crate) fn new(
        kernel: &'a dyn Kernel,
        noise: Noise<'a>,
        likelihood: Likelihood<'a>,
    ) -> Self {
        let gradient = vec![0.0; kernel.parameters().len() + 1];
        Self { kernel, noise, likelihood, gradient }
    }

    /// ln p(y | X) in nats; fills the gradient. O(N³), without allocating matrices.
    ///
    /// # Errors
    /// `NotPositiveDefinite`.
    pub fn evaluate(&mut self) -> Result<f64, GpError> {
        self.likelihood.evaluate(self.kernel, self.noise, &mut self.gradient)
    }

    /// What `evaluate` found: by the kernel's log-parameters and, last, by ln σₙ².
    pub fn gradient(&self) -> &[f64] {
        &self.gradient
    }
}
