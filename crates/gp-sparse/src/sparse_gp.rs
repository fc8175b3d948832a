//! The sparse Gaussian process and its predictions.

use std::sync::Arc;

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};
use gp_core::blocks::{PredictBlock, mean_in_blocks, predict_blocks_into, predict_in_blocks};
use gp_core::checks::{check_inputs, check_outputs, check_positive, check_row_noise};
use gp_core::kernel::{
    check_kernel_and_inputs, column_of, fill_cross, fill_lower_gram, mirror_lower,
};
use gp_core::triangle::{add_outer, inverse, multiply_rows_transposed};
use gp_core::vector::{add_multiple, add_square};
use gp_core::{GpError, JointGaussian, Kernel, Monomials, Posterior, Workspace};

use crate::SparseSettings;
use crate::deviation::Deviation;
use crate::objective::Objective;
use crate::reduction::reduction;
use crate::report::SparseReport;
use crate::row_sums::RowSums;

/// A Gaussian process seen through its values u at M pseudo-inputs Z; of the data it keeps
/// sums alone.
///
/// - f mean: m + k*ᵀ w with w = K_uu⁻¹ (E(u) − m), in O(M) an input.
/// - f variance: k** − k*ᵀ (K_uu⁻¹ − Σ) k* with Σ = (K_uu + K_uf D⁻¹ K_fu)⁻¹, in O(M²) an input.
/// - to which is added, of a learnt mean, what the data leave open of it: of a constant m the variance
///   1/(1ᵀC1) of it times (1 − k*ᵀ K_uu⁻¹ K_uf C 1)², with C the inverse of what [`Approximation`] takes for the
///   covariance of the data. It is the exact process' term with that covariance.
///
/// The thesis' eq. 3.24 adds σₙ² and is the variance of an observation.
///
/// [`Approximation`]: crate::Approximation
#[derive(Clone, Debug)]
pub struct SparseGp {
    pub(crate) kernel: Arc<dyn Kernel>,
    pub(crate) settings: SparseSettings,
    pub(crate) noise_variance: f64,
    pub(crate) z: Mat<f64>,
    /// The mean of f.
    pub(crate) mean: Deviation,
    /// Of a learnt mean, one a coefficient.
    pub(crate) deviations: Vec<Deviation>,
    /// What a learnt mean is a sum of.
    pub(crate) monomials: Monomials,
    /// What is kept of the rows; nothing in a process that was saved without.
    pub(crate) sums: Option<RowSums>,
    /// L⁻¹ with K_uu = L Lᵀ, and zeros above the diagonal.
    pub(crate) factor_inverse: Mat<f64>,
    /// R with R Rᵀ = I + L⁻¹ K_uf D⁻¹ K_fu L⁻ᵀ.
    pub(crate) root: Mat<f64>,
    /// R⁻¹, with zeros above the diagonal.
    pub(crate) root_inverse: Mat<f64>,
    /// T with TᵀT = K_uu⁻¹ − Σ, and zeros above the diagonal.
    pub(crate) reduction: Mat<f64>,
    pub(crate) objective: f64,
    pub(crate) report: Option<Arc<SparseReport>>,
}

/// The objective and its gradient at the parameters of a process, on data of its own.
pub struct Evaluator {
    kernel: Arc<dyn Kernel>,
    noise_variance: f64,
    z: Vec<f64>,
    objective: Objective,
    gradient: Vec<f64>,
}

impl Evaluator {
    /// The objective in nats; fills the gradient. O(N M²).
    ///
    /// # Errors
    /// `NotPositiveDefinite` if pseudo-inputs are too close to each other for the jitter.
    pub fn evaluate(&mut self) -> Result<f64, GpError> {
        let value = self.objective.value(&*self.kernel, self.noise_variance, &self.z)?;
        self.objective.differentiate(&*self.kernel, self.noise_variance, &mut self.gradient);
        Ok(value)
    }

    /// What `evaluate` found: by the kernel's log-parameters, ln σₙ², and the pseudo-inputs.
    pub fn gradient(&self) -> &[f64] {
        &self.gradient
    }
}

impl SparseGp {
    /// Conditions known parameters on data through the pseudo-inputs `z`; O(N M²).
    ///
    /// - `x`: inputs, N×D; `y`: outputs, N; `z`: pseudo-inputs, M×D, as many as you like.
    /// - `noise_variance`: of an observation, positive, in the squared unit of the output.
    ///
    /// # Errors
    /// `Empty`, `ShapeMismatch`, `NotFinite`, `NotPositive`, `OutOfRange`; `NotPositiveDefinite`
    /// if pseudo-inputs are too close to each other for the jitter.
    pub fn fit(
        kernel: impl Kernel + 'static,
        x: MatRef<'_, f64>,
        y: &[f64],
        z: MatRef<'_, f64>,
        noise_variance: f64,
        settings: SparseSettings,
    ) -> Result<Self, GpError> {
        Self::fit_with_row_noise(kernel, x, y, &[], z, noise_variance, settings)
    }

    /// As `fit`, where observations have known noise of their own beside the common one.
    ///
    /// - `row_noise`: variance a row, N, not negative, in the squared unit of the output; or none.
    ///
    /// # Errors
    /// As `fit`; `Negative` for a noise that is.
    pub fn fit_with_row_noise(
        kernel: impl Kernel + 'static,
        x: MatRef<'_, f64>,
        y: &[f64],
        row_noise: &[f64],
        z: MatRef<'_, f64>,
        noise_variance: f64,
        settings: SparseSettings,
    ) -> Result<Self, GpError> {
        let kernel: Arc<dyn Kernel> = Arc::new(kernel);
        check_data(&*kernel, x, y)?;
        check_row_noise(row_noise, y.len())?;
        check_inputs("pseudo-inputs", z, x.ncols())?;
        check_positive("noise variance", noise_variance)?;
        settings.check()?;
        Self::condition(kernel, (x, y, row_noise), &rows_of(z), noise_variance, settings)
    }

    /// As `fit`, with arguments that have been checked and `z` by rows.
    pub(crate) fn condition(
        kernel: Arc<dyn Kernel>,
        (x, y, row_noise): (MatRef<'_, f64>, &[f64], &[f64]),
        z: &[f64],
        noise_variance: f64,
        settings: SparseSettings,
    ) -> Result<Self, GpError> {
        let d = x.ncols();
        let m = z.len() / d;
        // Of all rows no more than a block is in memory.
        let mut objective = Objective::empty((x, y), m, settings);
        let value = objective.value_of((x, y, row_noise), &*kernel, noise_variance, z)?;
        check_outputs("objective", &[value], 1)?;
        let root_inverse = inverse(objective.solved.root.as_ref());
        Ok(Self {
            kernel,
            settings,
            noise_variance,
            z: Mat::from_fn(m, d, |a, j| z[a * d + j]),
            mean: objective.solved.mean(objective.sums.origin),
            deviations: objective.solved.deviations(),
            monomials: objective.sums.monomials.clone(),
            reduction: reduction(objective.factor_inverse.as_ref(), root_inverse.as_ref())?,
            factor_inverse: objective.factor_inverse,
            root_inverse,
            root: objective.solved.root,
            sums: Some(objective.sums),
            objective: value,
            report: None,
        })
    }

    /// The objective and its gradient: by the kernel's log-parameters, ln σₙ², and the
    /// pseudo-inputs, M×D by rows; O(N M²).
    ///
    /// # Errors
    /// As `fit`.
    pub fn objective_and_gradient(
        &self,
        x: MatRef<'_, f64>,
        y: &[f64],
    ) -> Result<(f64, Vec<f64>), GpError> {
        let mut evaluator = self.evaluator(x, y)?;
        let value = evaluator.evaluate()?;
        Ok((value, evaluator.gradient))
    }

    /// The same again and again without allocating, as while learning.
    ///
    /// # Errors
    /// As `fit`.
    pub fn evaluator(&self, x: MatRef<'_, f64>, y: &[f64]) -> Result<Evaluator, GpError> {
        self.evaluator_with_row_noise(x, y, &[])
    }

    /// As `evaluator`, with known noise of the rows, N, or none.
    ///
    /// # Errors
    /// As `fit_with_row_noise`.
    pub fn evaluator_with_row_noise(
        &self,
        x: MatRef<'_, f64>,
        y: &[f64],
        row_noise: &[f64],
    ) -> Result<Evaluator, GpError> {
        check_data(&*self.kernel, x, y)?;
        check_row_noise(row_noise, y.len())?;
        let (m, n_parameters) = (self.mean.weights.len(), self.kernel.parameters().len());
        Ok(Evaluator {
            kernel: self.kernel.clone(),
            noise_variance: self.noise_variance,
            z: rows_of(self.z.as_ref()),
            objective: Objective::new(x, y, row_noise, m, n_parameters, self.settings),
            gradient: vec![0.0; n_parameters + 1 + m * x.ncols()],
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

    /// The constant mean m, in the unit of the output; of a linear mean or a polynomial its value at x = 0.
    pub fn mean(&self) -> f64 {
        let Deviation { constant, coefficients, .. } = &self.mean;
        let mut value = [*constant];
        self.monomials.add(Mat::zeros(1, self.z.ncols()).as_ref(), coefficients, &mut value);
        value[0]
    }

    /// Writes c + Σ g_k h_k(x) of every row.
    fn fill(&self, one: &Deviation, x: MatRef<'_, f64>, values: &mut [f64]) {
        values.fill(one.constant);
        self.monomials.add(x, &one.coefficients, values);
    }

    /// A deviation, or the mean, at every row.
    fn values(&self, one: &Deviation, x: MatRef<'_, f64>) -> Result<Vec<f64>, GpError> {
        let known = (self.z.as_ref(), &*one.weights);
        mean_in_blocks(&*self.kernel, x, known, |rows, values| self.fill(one, rows, values))
    }

    /// The approximation, the choice of the mean, and the jitter.
    pub fn settings(&self) -> SparseSettings {
        self.settings
    }

    /// The pseudo-inputs Z, M×D.
    pub fn pseudo_inputs(&self) -> MatRef<'_, f64> {
        self.z.as_ref()
    }

    /// What was maximised, in nats: the approximate ln p(y | X), and with `Vfe` a lower bound of it.
    pub fn objective(&self) -> f64 {
        self.objective
    }
}

impl Posterior for SparseGp {
    fn n_inputs(&self) -> usize {
        self.z.ncols()
    }

    fn predict_mean(&self, x_star: MatRef<'_, f64>) -> Result<Vec<f64>, GpError> {
        self.values(&self.mean, x_star)
    }

    fn predict(&self, x_star: MatRef<'_, f64>) -> Result<(Vec<f64>, Vec<f64>), GpError> {
        predict_in_blocks(self, x_star)
    }

    fn predict_into(
        &self,
        x_star: MatRef<'_, f64>,
        workspace: &mut Workspace,
        mean: &mut [f64],
        variance: &mut [f64],
    ) -> Result<(), GpError> {
        predict_blocks_into(self, x_star, workspace, mean, variance)
    }

    fn predict_joint(&self, x_star: MatRef<'_, f64>) -> Result<JointGaussian, GpError> {
        let mean = self.predict_mean(x_star)?;
        let mut cross = Mat::zeros(x_star.nrows(), self.mean.weights.len());
        fill_cross(&*self.kernel, x_star, self.z.as_ref(), cross.as_mut());
        let mut covariance = Mat::zeros(x_star.nrows(), x_star.nrows());
        fill_lower_gram(&*self.kernel, x_star, &mut covariance);
        let mut whitened = cross.clone();
        for (inverse, sign) in [(&self.factor_inverse, -1.0), (&self.root_inverse, 1.0)] {
            multiply_rows_transposed(whitened.as_mut(), cross.as_ref(), inverse.as_ref());
            let sum = covariance.as_mut();
            matmul(sum, Accum::Add, &whitened, whitened.transpose(), sign, Par::Seq);
            std::mem::swap(&mut cross, &mut whitened);
        }
        for j in 0..covariance.ncols() {
            covariance[(j, j)] = covariance[(j, j)].max(0.0);
        }
        for deviation in &self.deviations {
            add_outer(&mut covariance, &self.values(deviation, x_star)?);
        }
        mirror_lower(&mut covariance);
        JointGaussian::new(mean, covariance)
    }

    fn predict_noise(&self, x_star: MatRef<'_, f64>) -> Result<Vec<f64>, GpError> {
        check_inputs("inputs", x_star, self.n_inputs())?;
        Ok(vec![self.noise_variance; x_star.nrows()])
    }
}

impl PredictBlock for SparseGp {
    const ROWS: usize = 240;

    fn predict_block(
        &self,
        x_star: MatRef<'_, f64>,
        workspace: &mut Workspace,
        mean: &mut [f64],
        variance: &mut [f64],
    ) {
        let m = self.mean.weights.len();
        let (mut cross, mut whitened) = workspace.matrices(x_star.nrows(), m);
        fill_cross(&*self.kernel, x_star, self.z.as_ref(), cross.as_mut());
        self.fill(&self.mean, x_star, mean);
        for (a, weight) in self.mean.weights.iter().enumerate() {
            add_multiple(mean, *weight, column_of(cross.as_mut(), a));
        }
        self.kernel.diagonal(x_star, variance);
        multiply_rows_transposed(whitened.as_mut(), cross.as_ref(), self.reduction.as_ref());
        for a in 0..m {
            add_square(variance, -1.0, column_of(whitened.as_mut(), a));
        }
        // Rounding alone can make the difference of two nearly equal variances negative.
        variance.iter_mut().for_each(|variance| *variance = variance.max(0.0));
        for deviation in &self.deviations {
            let moved = column_of(whitened.as_mut(), 0);
            self.fill(deviation, x_star, moved);
            for (a, weight) in deviation.weights.iter().enumerate() {
                add_multiple(moved, *weight, column_of(cross.as_mut(), a));
            }
            add_square(variance, 1.0, moved);
        }
    }
}

pub(crate) fn check_data(
    kernel: &dyn Kernel,
    x: MatRef<'_, f64>,
    y: &[f64],
) -> Result<(), GpError> {
    check_kernel_and_inputs(kernel, x)?;
    check_outputs("outputs", y, x.nrows())
}

/// A matrix by rows.
pub(crate) fn rows_of(x: MatRef<'_, f64>) -> Vec<f64> {
    (0..x.nrows()).flat_map(|i| (0..x.ncols()).map(move |d| x[(i, d)])).collect()
}
