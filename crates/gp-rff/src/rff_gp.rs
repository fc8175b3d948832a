//! Bayesian linear regression on random features: an approximate Gaussian process.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par};
use gp_core::blocks::{PredictBlock, predict_blocks_into, predict_in_blocks};
use gp_core::checks::{check_inputs, check_outputs, check_positive};
use gp_core::kernel::{column_of, mirror_lower};
use gp_core::triangle::{add_outer, inverse, multiply_rows_transposed};
use gp_core::vector::{add_multiple, add_square};
use gp_core::{GpError, JointGaussian, Mean, Posterior, Workspace};
use rayon::prelude::{IndexedParallelIterator, ParallelIterator, ParallelSliceMut};

use crate::evidence::Evidence;
use crate::statistics::BLOCK;
use crate::{RandomFeatures, SufficientStatistics};

/// f(x) = m + s φ(x)ᵀw with w ~ N(0, I), conditioned on the statistics of the data.
///
/// - f mean: m + s φ*ᵀt, in O(M) an input.
/// - f variance: σₙ² s² φ*ᵀB⁻¹φ* with B = s²ΦᵀΦ + σₙ² I, in O(M²) an input, to which is added, of a
///   learnt mean m, what the data leave open of it: that of one more feature, 1, whose weight has a
///   prior without end.
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
    constant: f64,
    pub(crate) weights: Vec<f64>,
    /// c and t of the deviation c + s φᵀt, by which f moves with a standard deviation of a learnt mean.
    pub(crate) deviation: Option<(f64, Vec<f64>)>,
    /// R⁻¹ with B = R Rᵀ, and zeros above the diagonal.
    pub(crate) root_inverse: Mat<f64>,
    log_evidence: f64,
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
        check_inputs("inputs", x, features.n_inputs())?;
        check_outputs("outputs", y, x.nrows())?;
        let origin = y.iter().sum::<f64>() / y.len() as f64;
        let mut statistics = SufficientStatistics::new(&features, origin)?;
        statistics.update(&features, x, y)?;
        let mean = Mean::Estimated;
        Self::from_statistics(features, statistics, signal_variance, noise_variance, mean)
    }

    /// Conditions on data of which only the statistics are there; O(M³).
    ///
    /// # Errors
    /// `Incompatible` if they are of other features; `TooFewRows` without rows; else as `fit`.
    pub fn from_statistics(
        features: RandomFeatures,
        statistics: SufficientStatistics,
        signal_variance: f64,
        noise_variance: f64,
        mean: Mean,
    ) -> Result<Self, GpError> {
        check_positive("signal variance", signal_variance)?;
        check_positive("noise variance", noise_variance)?;
        mean.check_constant()?;
        statistics.check_features(&features)?;
        if statistics.n_rows() == 0 {
            return Err(GpError::TooFewRows { needed: 1, actual: 0 });
        }
        let evidence = Evidence::new(&statistics, signal_variance, noise_variance, mean)?;
        Ok(Self {
            constant: statistics.origin() + evidence.mean.constant,
            weights: evidence.mean.weights,
            deviation: evidence.deviation.map(|one| (one.constant, one.weights)),
            root_inverse: inverse(evidence.root.as_ref()),
            log_evidence: evidence.value,
            features,
            statistics,
            signal_variance,
            noise_variance,
            mean,
        })
    }

    /// Takes in more rows with the hyperparameters as they are; O(rows M² + M³).
    ///
    /// # Errors
    /// As `fit`; the process is left as it was.
    pub fn update(&mut self, x: MatRef<'_, f64>, y: &[f64]) -> Result<(), GpError> {
        let mut statistics = self.statistics.clone();
        statistics.update(&self.features, x, y)?;
        *self = Self::from_statistics(
            self.features.clone(),
            statistics,
            self.signal_variance,
            self.noise_variance,
            self.mean,
        )?;
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

    /// The constant mean m, in the unit of the output.
    pub fn mean(&self) -> f64 {
        self.constant
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
        let (mut phi, mut whitened) = workspace.matrices(x_star.nrows(), self.weights.len());
        self.evaluate(x_star, phi.as_mut(), mean);
        let root_inverse = self.root_inverse.as_ref();
        multiply_rows_transposed(whitened.as_mut(), phi.as_ref(), root_inverse);
        [phi, whitened]
    }

    /// Means, and φ by rows.
    fn evaluate(&self, x_star: MatRef<'_, f64>, mut phi: MatMut<'_, f64>, mean: &mut [f64]) {
        self.features.fill(x_star, phi.as_mut(), None);
        self.combine(self.constant, &self.weights, phi, mean);
    }

    /// c + s φᵀt of each row.
    fn combine(&self, c: f64, t: &[f64], mut phi: MatMut<'_, f64>, values: &mut [f64]) {
        let signal_sd = self.signal_variance.sqrt();
        values.fill(c);
        for (j, weight) in t.iter().enumerate() {
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
            let (phi, _) = workspace.matrices(mean.len(), self.weights.len());
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
        let [phi, half] = self.whiten(x_star, &mut workspace, &mut mean);
        let half = half.as_ref();
        let mut covariance = Mat::zeros(n, n);
        let scale = self.noise_variance * self.signal_variance;
        let sum = covariance.as_mut();
        matmul(sum, Accum::Replace, half, half.transpose(), scale, Par::Seq);
        if let Some((c, t)) = &self.deviation {
            let mut moved = vec![0.0; n];
            self.combine(*c, t, phi, &mut moved);
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
        let [phi, mut whitened] = self.whiten(x_star, workspace, mean);
        let scale = self.noise_variance * self.signal_variance;
        variance.fill(0.0);
        for j in 0..whitened.ncols() {
            add_square(variance, scale, column_of(whitened.as_mut(), j));
        }
        if let Some((c, t)) = &self.deviation {
            let moved = column_of(whitened, 0);
            self.combine(*c, t, phi, moved);
            add_square(variance, 1.0, moved);
        }
    }
}
