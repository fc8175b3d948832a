//! Bayesian linear regression on random features: an approximate Gaussian process.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};
use gp_core::checks::{check_inputs, check_outputs, check_positive};
use gp_core::kernel::{column, mirror_lower};
use gp_core::triangle::solve_rows;
use gp_core::vector::{add_multiple, vectorized};
use gp_core::{GpError, JointGaussian, Mean, Posterior};
use rayon::prelude::{IndexedParallelIterator, ParallelIterator, ParallelSliceMut};

use crate::evidence::Evidence;
use crate::statistics::BLOCK;
use crate::{RandomFeatures, SufficientStatistics};

/// f(x) = m + s φ(x)ᵀw with w ~ N(0, I), conditioned on the statistics of the data.
///
/// - f mean: m + s φ*ᵀt, in O(M) an input.
/// - f variance: σₙ² s² φ*ᵀB⁻¹φ* with B = s²ΦᵀΦ + σₙ² I, in O(M²) an input.
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
    weights: Vec<f64>,
    root: Mat<f64>,
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
            constant: statistics.origin() + evidence.constant,
            weights: evidence.weights,
            root: evidence.root,
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

    /// Means, and φ by rows.
    fn evaluate(&self, x_star: MatRef<'_, f64>, mean: &mut [f64]) -> Mat<f64> {
        let mut phi = Mat::zeros(x_star.nrows(), self.weights.len());
        self.features.fill(x_star, &mut phi, None);
        let signal_sd = self.signal_variance.sqrt();
        mean.fill(self.constant);
        for (j, weight) in self.weights.iter().enumerate() {
            add_multiple(mean, signal_sd * weight, column(&phi, j));
        }
        phi
    }

    /// Means, and φR⁻ᵀ by rows.
    fn whiten(&self, x_star: MatRef<'_, f64>, mean: &mut [f64]) -> Mat<f64> {
        let mut phi = self.evaluate(x_star, mean);
        solve_rows(self.root.as_ref(), phi.as_mut());
        phi
    }
}

impl Posterior for RffGp {
    fn n_inputs(&self) -> usize {
        self.features.n_inputs()
    }

    fn predict_mean(&self, x_star: MatRef<'_, f64>) -> Result<Vec<f64>, GpError> {
        check_inputs("inputs", x_star, self.n_inputs())?;
        let mut mean = vec![0.0; x_star.nrows()];
        mean.par_chunks_mut(BLOCK).enumerate().for_each(|(block, mean)| {
            self.evaluate(x_star.subrows(block * BLOCK, mean.len()), mean);
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
                let whitened = self.whiten(rows, mean);
                let scale = self.noise_variance * self.signal_variance;
                for j in 0..whitened.ncols() {
                    let half = column(&whitened, j);
                    vectorized(|| {
                        for (variance, half) in variance.iter_mut().zip(half) {
                            *variance += scale * (half * half);
                        }
                    });
                }
            },
        );
        Ok((mean, variance))
    }

    fn predict_joint(&self, x_star: MatRef<'_, f64>) -> Result<JointGaussian, GpError> {
        check_inputs("inputs", x_star, self.n_inputs())?;
        let n = x_star.nrows();
        let mut mean = vec![0.0; n];
        let half = self.whiten(x_star, &mut mean);
        let mut covariance = Mat::zeros(n, n);
        let scale = self.noise_variance * self.signal_variance;
        let sum = covariance.as_mut();
        matmul(sum, Accum::Replace, &half, half.transpose(), scale, Par::Seq);
        mirror_lower(&mut covariance);
        JointGaussian::new(mean, covariance)
    }

    fn predict_noise(&self, x_star: MatRef<'_, f64>) -> Result<Vec<f64>, GpError> {
        check_inputs("inputs", x_star, self.n_inputs())?;
        Ok(vec![self.noise_variance; x_star.nrows()])
    }
}
