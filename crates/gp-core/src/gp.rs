//! The exact Gaussian process with Gaussian noise.

use std::sync::Arc;

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};

use crate::blocks::{PredictBlock, mean_in_blocks, predict_blocks_into, predict_in_blocks};
use crate::checks::{check_distinct_rows, check_inputs, check_outputs, check_positive};
use crate::factor::Factor;
use crate::kernel::{
    check_kernel_and_inputs, column_mut, column_of, fill_cross, fill_lower_gram, mirror_lower,
};
use crate::likelihood::{Evaluator, Likelihood};
use crate::mean::{Deviation, Residual, Trend};
use crate::noise::Noise;
use crate::triangle::add_outer;
use crate::vector::{add_multiple, add_square};
use crate::{GpError, JointGaussian, Kernel, LearnReport, LeaveOneOut, Mean, Posterior, Workspace};

/// A Gaussian process conditioned on data: y = f(x) + noise, f ~ GP(m, k), noise ~ N(0, σₙ²).
///
/// - f mean: m* + k*ᵀ (K + σₙ² I)⁻¹ (y − m), in O(N) an input.
/// - f variance: k** − k*ᵀ (K + σₙ² I)⁻¹ k* + rᵀ (Hᵀ(K + σₙ² I)⁻¹H)⁻¹ r, in O(N²) an input.
///
/// The last term, with r = h* − Hᵀ(K + σₙ² I)⁻¹ k*, is what the data leave open of a learnt mean hᵀβ
/// (see [`Mean`]): far from them the variance is larger than the prior's, and grows without end with a
/// linear mean. About a known mean it never exceeds the prior's. The hyperparameters of kernel and
/// noise are taken as known.
///
/// # Source
/// Rasmussen & Williams, Gaussian Processes for Machine Learning (2006), ch. 2, eq. 2.42; the thesis,
/// eq. 3.10.
#[derive(Clone, Debug)]
pub struct Gp {
    kernel: Arc<dyn Kernel>,
    pub(crate) x: Arc<Mat<f64>>,
    pub(crate) y: Vec<f64>,
    noise_variance: f64,
    /// Known noise of each row beside the common one; empty if there is none.
    pub(crate) row_noise: Vec<f64>,
    mean: Mean,
    pub(crate) trend: Trend,
    pub(crate) deviations: Vec<Deviation>,
    /// Of the covariance of the observations.
    pub(crate) factor: Arc<Factor>,
    pub(crate) weights: Vec<f64>,
    log_marginal_likelihood: f64,
    pub(crate) report: Option<Arc<LearnReport>>,
}

impl Gp {
    pub(crate) fn condition(
        kernel: Arc<dyn Kernel>,
        x: MatRef<'_, f64>,
        y: &[f64],
        noise: Noise<'_>,
        mean: Mean,
    ) -> Result<Self, GpError> {
        check_kernel_and_inputs(&*kernel, x)?;
        check_outputs("outputs", y, x.nrows())?;
        noise.check()?;
        mean.check()?;
        if noise.common == 0.0 && noise.of_rows.iter().all(|&noise| noise == 0.0) {
            check_distinct_rows(x)?;
        }
        let x = x.to_owned();
        let factor = Factor::new(&*kernel, x.as_ref(), noise)?;
        let Residual { trend, deviations, weights, log_likelihood } =
            Residual::solve(&factor, x.as_ref(), y, mean)?;
        Ok(Self {
            kernel,
            x: Arc::new(x),
            y: y.to_vec(),
            noise_variance: noise.common,
            row_noise: noise.of_rows.to_vec(),
            mean,
            trend,
            deviations,
            factor: Arc::new(factor),
            weights,
            log_marginal_likelihood: log_likelihood,
            report: None,
        })
    }

    /// The same inputs, kernel and noise with other outputs, by the same factorisation; O(N²).
    ///
    /// Several outputs that share their hyperparameters take one fit and this for each of the
    /// others.
    ///
    /// # Errors
    /// `ShapeMismatch` or `NotFinite` if `y` does not hold N finite values.
    pub fn with_outputs(&self, y: &[f64]) -> Result<Self, GpError> {
        check_outputs("outputs", y, self.y.len())?;
        let mut other = Self { y: y.to_vec(), report: None, ..self.clone() };
        other.solve()?;
        Ok(other)
    }

    /// Solves for mean and weights again after outputs or the factor have changed; O(N²).
    pub(crate) fn solve(&mut self) -> Result<(), GpError> {
        let residual = Residual::solve(&*self.factor, self.inputs(), &self.y, self.mean)?;
        self.trend = residual.trend;
        self.deviations = residual.deviations;
        self.weights = residual.weights;
        self.log_marginal_likelihood = residual.log_likelihood;
        Ok(())
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
        self.trend.constant()
    }

    /// The slopes of a linear mean, one an input; none of a constant one, and of a polynomial those at the
    /// first row.
    pub fn mean_slopes(&self) -> &[f64] {
        self.trend.slopes()
    }

    /// Whether the mean was learnt or given.
    pub fn mean_choice(&self) -> Mean {
        self.mean
    }

    /// The training inputs, N×D.
    pub fn inputs(&self) -> MatRef<'_, f64> {
        self.x.as_ref().as_ref()
    }

    /// Known noise variance of each row beside the common one; empty if there is none.
    pub fn row_noise(&self) -> &[f64] {
        &self.row_noise
    }

    /// The training outputs, N.
    pub fn outputs(&self) -> &[f64] {
        &self.y
    }

    /// ln p(y | X), the log density of the outputs in the user's units, in nats.
    ///
    /// With P learnt coefficients of the mean it is the density of the N − P combinations of outputs
    /// that the mean does not touch, so that it compares kernels, and no means with each other.
    /// Outputs in a unit s times smaller lower it by (N − P) ln s (the Jacobian of that change).
    pub fn log_marginal_likelihood(&self) -> f64 {
        self.log_marginal_likelihood
    }

    /// ∂ ln p(y | X)/∂ ln θ for the kernel's parameters and, last, the noise variance; O(N³).
    ///
    /// # Errors
    /// `NotPositive` if the noise variance is 0, which has no logarithm.
    pub fn log_marginal_likelihood_gradient(&self) -> Result<Vec<f64>, GpError> {
        let mut evaluator = self.evaluator()?;
        evaluator.evaluate()?;
        Ok(evaluator.gradient().to_vec())
    }

    /// The likelihood with its gradient again and again without allocating, as while learning.
    ///
    /// # Errors
    /// As `log_marginal_likelihood_gradient`.
    pub fn evaluator(&self) -> Result<Evaluator<'_>, GpError> {
        check_positive("noise variance", self.noise_variance)?;
        let likelihood = Likelihood::new(self.inputs(), &self.y, self.mean);
        let noise = Noise { common: self.noise_variance, of_rows: &self.row_noise };
        Ok(Evaluator::new(&*self.kernel, noise, likelihood))
    }

    /// The prediction of every training row from all the others, in closed form; O(N³).
    ///
    /// # Errors
    /// `UndeterminedWithout` where a learnt mean is not determined without some row.
    pub fn leave_one_out(&self) -> Result<LeaveOneOut, GpError> {
        let whole = self.factor.inverse_diagonal();
        let mut diagonal = whole.clone();
        for deviation in &self.deviations {
            diagonal
                .iter_mut()
                .zip(&deviation.weights)
                .for_each(|(p, weight)| *p -= weight * weight);
        }
        let rounding = 8.0 * self.y.len() as f64 * f64::EPSILON;
        match (0..whole.len()).find(|&i| diagonal[i] <= rounding * whole[i]) {
            Some(row) => Err(GpError::UndeterminedWithout { row }),
            None => Ok(LeaveOneOut::new(&self.y, &self.weights, &diagonal)),
        }
    }

    /// A trend and a weighted sum of the kernel's columns, at each row.
    pub(crate) fn values(
        &self,
        trend: &Trend,
        weights: &[f64],
        x_star: MatRef<'_, f64>,
    ) -> Result<Vec<f64>, GpError> {
        let known = (self.inputs(), weights);
        mean_in_blocks(&*self.kernel, x_star, known, |rows, values| trend.fill(rows, values))
    }
}

impl Posterior for Gp {
    fn n_inputs(&self) -> usize {
        self.x.ncols()
    }

    fn predict_mean(&self, x_star: MatRef<'_, f64>) -> Result<Vec<f64>, GpError> {
        self.values(&self.trend, &self.weights, x_star)
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
        let mut cross = Mat::zeros(self.y.len(), x_star.nrows());
        fill_cross(&*self.kernel, self.inputs(), x_star, cross.as_mut());
        self.factor.solve_columns(cross.as_mut());
        let mut covariance = Mat::zeros(x_star.nrows(), x_star.nrows());
        fill_lower_gram(&*self.kernel, x_star, &mut covariance);
        matmul(covariance.as_mut(), Accum::Add, cross.transpose(), &cross, -1.0, Par::Seq);
        for j in 0..covariance.ncols() {
            let diagonal = &mut column_mut(&mut covariance, j)[j];
            *diagonal = diagonal.max(0.0);
        }
        for Deviation { trend, weights } in &self.deviations {
            add_outer(&mut covariance, &self.values(trend, weights, x_star)?);
        }
        mirror_lower(&mut covariance);
        JointGaussian::new(mean, covariance)
    }

    fn predict_noise(&self, x_star: MatRef<'_, f64>) -> Result<Vec<f64>, GpError> {
        check_inputs("inputs", x_star, self.n_inputs())?;
        Ok(vec![self.noise_variance; x_star.nrows()])
    }
}

impl PredictBlock for Gp {
    const ROWS: usize = 128;

    fn predict_block(
        &self,
        x_star: MatRef<'_, f64>,
        workspace: &mut Workspace,
        mean: &mut [f64],
        variance: &mut [f64],
    ) {
        let n = self.y.len();
        let (mut cross, mut moved) = workspace.matrices(x_star.nrows(), n);
        fill_cross(&*self.kernel, x_star, self.inputs(), cross.as_mut());
        self.trend.fill(x_star, mean);
        for (j, weight) in self.weights.iter().enumerate() {
            add_multiple(mean, *weight, column_of(cross.as_mut(), j));
        }
        // There are no more learnt coefficients than rows of data.
        for (c, Deviation { trend, weights }) in self.deviations.iter().enumerate() {
            let moved = column_of(moved.as_mut(), c);
            trend.fill(x_star, moved);
            for (j, weight) in weights.iter().enumerate() {
                add_multiple(moved, *weight, column_of(cross.as_mut(), j));
            }
        }
        self.factor.solve_rows(cross.as_mut());
        self.kernel.diagonal(x_star, variance);
        for j in 0..n {
            add_square(variance, -1.0, column_of(cross.as_mut(), j));
        }
        // Rounding alone can make the difference of two nearly equal variances negative.
        variance.iter_mut().for_each(|variance| *variance = variance.max(0.0));
        for c in 0..self.deviations.len() {
            add_square(variance, 1.0, column_of(moved.as_mut(), c));
        }
    }
}
