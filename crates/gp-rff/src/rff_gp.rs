//! Bayesian linear regression on random features: an approximate Gaussian process.

use std::sync::Arc;

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par};
use gp_core::blocks::{PredictBlock, predict_blocks_into, predict_in_blocks};
use gp_core::checks::{check_inputs, check_outputs, check_positive};
use gp_core::kernel::{column_of, mirror_lower};
use gp_core::triangle::{add_outer, inverse, multiply_rows_transposed};
use gp_core::vector::{add_multiple, add_square};
use gp_core::{GpError, JointGaussian, Mean, Monomials, Posterior, Workspace};
use rayon::prelude::{IndexedParallelIterator, ParallelIterator, ParallelSliceMut};

use crate::evidence::{Evidence, Response};
use crate::feature_rows::BLOCK;
use crate::likelihood::empty_statistics;
use crate::report::RffReport;
use crate::{RandomFeatures, SufficientStatistics};

/// f(x) = m(x) + s φ(x)ᵀw with w ~ N(0, I), conditioned on the statistics of the data.
///
/// - f mean: m + s φ*ᵀt, in O(M) an input.
/// - f variance: σₙ² s² φ*ᵀB⁻¹φ* with B = s²ΦᵀWΦ + σₙ² I, in O(M²) an input, to which is added, of a
///   learnt mean m, what the data leave open of it: that of features more, whose weights have a
///   prior without end: 1, and of a linear mean the inputs.
/// - W are 1, but for rows with noise of their own beside σₙ² (see [`SufficientStatistics`]).
///
/// The thesis leaves the variance out. Far from all data it returns to the prior only as far as the
/// features reach: with few of them it is too small there.
#[derive(Clone, Debug)]
pub struct RffGp {
    pub(crate) features: RandomFeatures,
    pub(crate) statistics: SufficientStatistics,
    pub(crate) signal_variance: f64,
    pub(crate) noise_variance: f64,
    pub(crate) mean: Mean,
    /// What a learnt mean is a sum of.
    pub(crate) monomials: Monomials,
    /// The mean of f.
    pub(crate) function: Function,
    /// By which f moves with a standard deviation of each direction of a learnt mean.
    pub(crate) deviations: Vec<Function>,
    /// R⁻¹ with B = R Rᵀ, and zeros above the diagonal.
    pub(crate) root_inverse: Mat<f64>,
    log_evidence: f64,
    pub(crate) report: Option<Arc<RffReport>>,
}

/// c + Σ g_k h_k(x) + s φ(x)ᵀt.
#[derive(Clone, Debug)]
pub(crate) struct Function {
    pub(crate) constant: f64,
    /// g, one a product of inputs; none of a constant mean.
    pub(crate) coefficients: Vec<f64>,
    /// t.
    pub(crate) weights: Vec<f64>,
}

impl Function {
    fn new(origin: f64, response: Response) -> Self {
        let (constant, rest) = response.coefficients.split_first().expect("1 is in every basis");
        let constant = origin + constant;
        Self { constant, coefficients: rest.to_vec(), weights: response.weights }
    }
}

impl RffGp {
    /// Conditions known hyperparameters on data, with an estimated constant mean; O(N M²).
    ///
    /// - `x`: inputs, N×D; `y`: outputs, N.
    /// - `signal_variance`, `noise_variance`: positive, in the squared unit of the output.
    ///
    /// # Errors
    /// `Empty`, `ShapeMismatch`, `NotFinite`, `NotPositive`; `NotPositiveDefinite` if the noise is
    /// lost beside the signal.
    pub fn fit(
        features: RandomFeatures,
        x: MatRef<'_, f64>,
        y: &[f64],
        signal_variance: f64,
        noise_variance: f64,
    ) -> Result<Self, GpError> {
        let (data, mean) = ((x, y, &[][..]), Mean::Estimated);
        Self::fit_with(features, data, signal_variance, noise_variance, mean)
    }

    /// As `fit`, with a mean of choice and known noise of the rows beside the common one.
    ///
    /// - `(x, y, row_noise)`: inputs, N×D, outputs, N, and noise variances, N, or none.
    ///
    /// # Errors
    /// As `fit`; `Negative` for a noise that is; `UndeterminedSlope` if the rows do not tell the slopes of
    /// a learnt mean.
    pub fn fit_with(
        features: RandomFeatures,
        (x, y, row_noise): (MatRef<'_, f64>, &[f64], &[f64]),
        signal_variance: f64,
        noise_variance: f64,
        mean: Mean,
    ) -> Result<Self, GpError> {
        check_inputs("inputs", x, features.n_inputs())?;
        check_outputs("outputs", y, x.nrows())?;
        let mut statistics = empty_statistics(&features, x, y, mean)?;
        if !row_noise.is_empty() {
            statistics = statistics.with_row_noise(noise_variance)?;
        }
        statistics.update_with_row_noise(&features, x, y, row_noise)?;
        Self::from_statistics(features, statistics, signal_variance, noise_variance, mean)
    }

    /// Conditions on data of which only the statistics are there; O(M³).
    ///
    /// # Errors
    /// `Incompatible` if they are of other features, have no sums for the mean, or weigh rows beside
    /// another noise variance; `TooFewRows` without rows; else as `fit_with`.
    pub fn from_statistics(
        features: RandomFeatures,
        statistics: SufficientStatistics,
        signal_variance: f64,
        noise_variance: f64,
        mean: Mean,
    ) -> Result<Self, GpError> {
        check_positive("signal variance", signal_variance)?;
        check_positive("noise variance", noise_variance)?;
        mean.check()?;
        statistics.check_features(&features)?;
        if statistics.weighed_beside().is_some_and(|other| other != noise_variance) {
            let what = "noise variances of the process and beside which rows were weighed";
            return Err(GpError::Incompatible { what });
        }
        if statistics.n_rows() == 0 {
            return Err(GpError::TooFewRows { needed: 1, actual: 0 });
        }
        let of_mean = (mean, features.n_inputs());
        let evidence = Evidence::new(&statistics, signal_variance, noise_variance, of_mean)?;
        let deviations = evidence.deviations.into_iter();
        Ok(Self {
            monomials: evidence.monomials,
            function: Function::new(statistics.origin(), evidence.mean),
            deviations: deviations.map(|one| Function::new(0.0, one)).collect(),
            root_inverse: inverse(evidence.root.as_ref()),
            log_evidence: evidence.value,
            features,
            statistics,
            signal_variance,
            noise_variance,
            mean,
            report: None,
        })
    }

    /// Takes in more rows with the hyperparameters as they are; O(rows M² + M³).
    ///
    /// # Errors
    /// As `fit`; the process is left as it was.
    pub fn update(&mut self, x: MatRef<'_, f64>, y: &[f64]) -> Result<(), GpError> {
        self.update_with_row_noise(x, y, &[])
    }

    /// As `update`, with known noise variances of the rows, N, or none.
    ///
    /// # Errors
    /// As `fit_with`; the process is left as it was.
    pub fn update_with_row_noise(
        &mut self,
        x: MatRef<'_, f64>,
        y: &[f64],
        row_noise: &[f64],
    ) -> Result<(), GpError> {
        let mut statistics = self.statistics.clone();
        if !row_noise.is_empty() {
            statistics = statistics.with_row_noise(self.noise_variance)?;
        }
        statistics.update_with_row_noise(&self.features, x, y, row_noise)?;
        let (features, mean) = (self.features.clone(), self.mean);
        let (signal, noise) = (self.signal_variance, self.noise_variance);
        let report = self.report.clone();
        *self =
            Self { report, ..Self::from_statistics(features, statistics, signal, noise, mean)? };
        Ok(())
    }

    /// The features, with their lengthscales.
    pub fn features(&self) -> &RandomFeatures {
        &self.features
    }

    /// What is kept of the data.
    pub fn statistics(&self) -> &SufficientStatistics {
        &self.statistics
    }

    /// The prior variance of the function, in the squared unit of the output.
    pub fn signal_variance(&self) -> f64 {
        self.signal_variance
    }

    /// The variance of the noise on an observation, in the squared unit of the output.
    pub fn noise_variance(&self) -> f64 {
        self.noise_variance
    }

    /// The constant mean m, in the unit of the output; of a linear mean or a polynomial its value at x = 0.
    pub fn mean(&self) -> f64 {
        let mut value = [self.function.constant];
        let zero = Mat::zeros(1, self.features.n_inputs());
        self.monomials.add(zero.as_ref(), &self.function.coefficients, &mut value);
        value[0]
    }

    /// The choice of the mean.
    pub fn mean_choice(&self) -> Mean {
        self.mean
    }

    /// ln p(y) under the features, in nats, the outputs in the user's unit.
    pub fn log_evidence(&self) -> f64 {
        self.log_evidence
    }

    /// Means, φ by rows, and φR⁻ᵀ.
    fn whiten<'a>(
        &self,
        x_star: MatRef<'_, f64>,
        workspace: &'a mut Workspace,
        mean: &mut [f64],
    ) -> [MatMut<'a, f64>; 2] {
        let (mut phi, mut whitened) =
            workspace.matrices(x_star.nrows(), self.function.weights.len());
        self.evaluate(x_star, phi.as_mut(), mean);
        let root_inverse = self.root_inverse.as_ref();
        multiply_rows_transposed(whitened.as_mut(), phi.as_ref(), root_inverse);
        [phi, whitened]
    }

    /// Means, and φ by rows.
    fn evaluate(&self, x_star: MatRef<'_, f64>, mut phi: MatMut<'_, f64>, mean: &mut [f64]) {
        self.features.fill(x_star, phi.as_mut(), None);
        self.combine(&self.function, x_star, phi, mean);
    }

    /// c + Σ g_k h_k(x) + s φᵀt of each row.
    fn combine(
        &self,
        function: &Function,
        x_star: MatRef<'_, f64>,
        mut phi: MatMut<'_, f64>,
        values: &mut [f64],
    ) {
        let signal_sd = self.signal_variance.sqrt();
        values.fill(function.constant);
        self.monomials.add(x_star, &function.coefficients, values);
        for (j, weight) in function.weights.iter().enumerate() {
            add_multiple(values, signal_sd * weight, column_of(phi.as_mut(), j));
        }
    }
}

impl Posterior for RffGp {
    fn n_inputs(&self) -> usize {
        self.features.n_inputs()
    }

    fn predict_mean(&self, x_star: MatRef<'_, f64>) -> Result<Vec<f64>, GpError> {
        check_inputs("inputs", x_star, self.n_inputs())?;
        let mut mean = vec![0.0; x_star.nrows()];
        let blocks = mean.par_chunks_mut(BLOCK).enumerate();
        blocks.for_each_init(Workspace::new, |workspace, (block, mean)| {
            let (phi, _) = workspace.matrices(mean.len(), self.function.weights.len());
            self.evaluate(x_star.subrows(block * BLOCK, mean.len()), phi, mean);
        });
        Ok(mean)
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
        check_inputs("inputs", x_star, self.n_inputs())?;
        let n = x_star.nrows();
        let mut mean = vec![0.0; n];
        let mut workspace = Workspace::new();
        let [mut phi, half] = self.whiten(x_star, &mut workspace, &mut mean);
        let half = half.as_ref();
        let mut covariance = Mat::zeros(n, n);
        let scale = self.noise_variance * self.signal_variance;
        let sum = covariance.as_mut();
        matmul(sum, Accum::Replace, half, half.transpose(), scale, Par::Seq);
        for deviation in &self.deviations {
            let mut moved = vec![0.0; n];
            self.combine(deviation, x_star, phi.as_mut(), &mut moved);
            add_outer(&mut covariance, &moved);
        }
        mirror_lower(&mut covariance);
        JointGaussian::new(mean, covariance)
    }

    fn predict_noise(&self, x_star: MatRef<'_, f64>) -> Result<Vec<f64>, GpError> {
        check_inputs("inputs", x_star, self.n_inputs())?;
        Ok(vec![self.noise_variance; x_star.nrows()])
    }
}

impl PredictBlock for RffGp {
    const ROWS: usize = BLOCK;

    fn predict_block(
        &self,
        x_star: MatRef<'_, f64>,
        workspace: &mut Workspace,
        mean: &mut [f64],
        variance: &mut [f64],
    ) {
        let [mut phi, mut whitened] = self.whiten(x_star, workspace, mean);
        let scale = self.noise_variance * self.signal_variance;
        variance.fill(0.0);
        for j in 0..whitened.ncols() {
            add_square(variance, scale, column_of(whitened.as_mut(), j));
        }
        for deviation in &self.deviations {
            let moved = column_of(whitened.as_mut(), 0);
            self.combine(deviation, x_star, phi.as_mut(), moved);
            add_square(variance, 1.0, moved);
        }
    }
}
