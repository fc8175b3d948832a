//! Bayesian linear regression on features.

use std::f64::consts::PI;

use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::solve_upper_triangular_in_place;
use faer::{Accum, Mat, MatRef, Par};

use crate::checks::{check_count, check_finite, check_inputs, check_outputs, check_positive};
use crate::cholesky::{Cholesky, log_determinant};
use crate::kernel::{column, mirror_lower};
use crate::{GpError, JointGaussian, LinearStatistics, Posterior};

/// y = φᵀw + noise with weights w ~ N(0, Σp) and noise ~ N(0, σₙ²), conditioned on data.
///
/// Features are rows here: Φ is N×M. With A = σₙ⁻² ΦᵀΦ + Σp⁻¹ the weights have mean σₙ⁻² A⁻¹ Φᵀy
/// and covariance A⁻¹, and f(φ*) has variance φ*ᵀA⁻¹φ*. (The thesis prints eq. 3.6 without the
/// first σₙ⁻²; this is the right form.) It equals the Gaussian process with mean 0 and kernel
/// φᵀΣpφ'. As a `Posterior`, its inputs are feature rows.
///
/// All that it needs of the data are sums over rows, [`LinearStatistics`], which merge.
///
/// Computed with Σp = L Lᵀ, Ψ = ΦL and B = ΨᵀΨ + σₙ² I, so that A⁻¹ = σₙ² L B⁻¹ Lᵀ; O(N M² + M³).
///
/// # Source
/// Rasmussen & Williams, Gaussian Processes for Machine Learning (2006), ch. 2; the thesis, eq.
/// 3.1 to 3.10.
#[derive(Clone, Debug)]
pub struct BayesianLinear {
    pub(crate) prior_factor: Mat<f64>,
    pub(crate) cholesky: Cholesky,
    pub(crate) weights: Vec<f64>,
    pub(crate) noise_variance: f64,
    pub(crate) log_evidence: f64,
}

impl BayesianLinear {
    /// Conditions the weights on data.
    ///
    /// - `features`: Φ, N×M, one observation a row.
    /// - `y`: outputs, N.
    /// - `prior_covariance`: Σp, M×M, of which the lower triangle is read.
    /// - `noise_variance`: σₙ², positive, in the squared unit of the output.
    ///
    /// # Errors
    /// `Empty`, `ShapeMismatch`, `NotFinite`, `NotPositive`; `NotPositiveDefinite` if Σp is not.
    pub fn fit(
        features: MatRef<'_, f64>,
        y: &[f64],
        prior_covariance: MatRef<'_, f64>,
        noise_variance: f64,
    ) -> Result<Self, GpError> {
        let m = features.ncols();
        check_inputs("features", features, m)?;
        check_outputs("outputs", y, features.nrows())?;
        let prior_factor = checked_factor(m, prior_covariance, noise_variance)?;
        let whitened = product(features, prior_factor.as_ref());
        let square = product(whitened.transpose(), whitened.as_ref());
        let outputs = MatRef::from_column_major_slice(y, y.len(), 1);
        let of_y = product(whitened.transpose(), outputs);
        let total: f64 = y.iter().map(|y| y * y).sum();
        Self::solved(prior_factor, square, of_y, (y.len() as f64, total), noise_variance)
    }

    /// Conditions the weights on the sums over rows of data, in O(M³) whatever their number.
    ///
    /// # Errors
    /// `ShapeMismatch`, `NotFinite`, `NotPositive`; `NotPositiveDefinite` if Σp is not.
    pub fn from_statistics(
        statistics: &LinearStatistics,
        prior_covariance: MatRef<'_, f64>,
        noise_variance: f64,
    ) -> Result<Self, GpError> {
        let m = statistics.n_features();
        let factor = checked_factor(m, prior_covariance, noise_variance)?;
        let square = product(factor.transpose(), statistics.square().as_ref());
        let square = product(square.as_ref(), factor.as_ref());
        let of_y = statistics.of_y();
        let of_y = MatRef::from_column_major_slice(&of_y, m, 1);
        let of_y = product(factor.transpose(), of_y);
        let (n, total) = (statistics.n_rows() as f64, statistics.y_y());
        Self::solved(factor, square, of_y, (n, total), noise_variance)
    }

    /// From ΨᵀΨ, Ψᵀy, and N and yᵀy.
    fn solved(
        prior_factor: Mat<f64>,
        mut matrix: Mat<f64>,
        mut solution: Mat<f64>,
        (n, total): (f64, f64),
        noise_variance: f64,
    ) -> Result<Self, GpError> {
        let m = matrix.nrows();
        for i in 0..m {
            matrix[(i, i)] += noise_variance;
        }
        let cholesky = Cholesky::new("precision of the weights", matrix)?;
        cholesky.solve_lower(solution.as_mut());
        let explained: f64 = column(&solution, 0).iter().map(|value| value * value).sum();
        let log_evidence = -0.5
            * ((total - explained) / noise_variance
                + log_determinant(cholesky.factor())
                + (n - m as f64) * noise_variance.ln()
                + n * (2.0 * PI).ln());
        let upper = cholesky.factor().transpose();
        solve_upper_triangular_in_place(upper, solution.as_mut(), Par::Seq);
        let weights = column(&product(prior_factor.as_ref(), solution.as_ref()), 0).to_vec();
        Ok(Self { prior_factor, cholesky, weights, noise_variance, log_evidence })
    }

    /// The posterior mean of the weights, M.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// The posterior covariance A⁻¹ of the weights, M×M.
    pub fn weight_covariance(&self) -> Mat<f64> {
        let half =
            self.half_deviation(Mat::identity(self.weights.len(), self.weights.len()).as_ref());
        self.covariance(&half)
    }

    /// The variance of the noise on an observation, in the squared unit of the output.
    pub fn noise_variance(&self) -> f64 {
        self.noise_variance
    }

    /// ln p(y | Φ), the log density of the outputs in the user's units, in nats.
    pub fn log_evidence(&self) -> f64 {
        self.log_evidence
    }

    /// R⁻¹ Lᵀ Φ*ᵀ with B = R Rᵀ, one input a column.
    fn half_deviation(&self, features: MatRef<'_, f64>) -> Mat<f64> {
        let mut half = product(self.prior_factor.transpose(), features.transpose());
        self.cholesky.solve_lower(half.as_mut());
        half
    }

    /// σₙ² HᵀH, exactly symmetric.
    fn covariance(&self, half: &Mat<f64>) -> Mat<f64> {
        let mut covariance = product(half.transpose(), half.as_ref()) * self.noise_variance;
        mirror_lower(&mut covariance);
        covariance
    }
}

impl Posterior for BayesianLinear {
    fn n_inputs(&self) -> usize {
        self.weights.len()
    }

    fn predict_mean(&self, x_star: MatRef<'_, f64>) -> Result<Vec<f64>, GpError> {
        check_inputs("features", x_star, self.n_inputs())?;
        let weights = MatRef::from_column_major_slice(&self.weights, self.weights.len(), 1);
        Ok(column(&product(x_star, weights), 0).to_vec())
    }

    fn predict(&self, x_star: MatRef<'_, f64>) -> Result<(Vec<f64>, Vec<f64>), GpError> {
        let mean = self.predict_mean(x_star)?;
        let half = self.half_deviation(x_star);
        let square = |j| column(&half, j).iter().map(|value| value * value).sum::<f64>();
        Ok((mean, (0..x_star.nrows()).map(|j| self.noise_variance * square(j)).collect()))
    }

    fn predict_joint(&self, x_star: MatRef<'_, f64>) -> Result<JointGaussian, GpError> {
        let mean = self.predict_mean(x_star)?;
        JointGaussian::new(mean, self.covariance(&self.half_deviation(x_star)))
    }

    fn predict_noise(&self, x_star: MatRef<'_, f64>) -> Result<Vec<f64>, GpError> {
        check_inputs("features", x_star, self.n_inputs())?;
        Ok(vec![self.noise_variance; x_star.nrows()])
    }
}

/// The factor of a prior covariance that fits M features.
fn checked_factor(
    m: usize,
    prior_covariance: MatRef<'_, f64>,
    noise_variance: f64,
) -> Result<Mat<f64>, GpError> {
    check_count("rows of the prior covariance", m, prior_covariance.nrows())?;
    check_count("columns of the prior covariance", m, prior_covariance.ncols())?;
    check_finite("prior covariance", prior_covariance)?;
    check_positive("noise variance", noise_variance)?;
    lower_factor(prior_covariance)
}

/// The Cholesky factor of a covariance with zeros above the diagonal.
fn lower_factor(covariance: MatRef<'_, f64>) -> Result<Mat<f64>, GpError> {
    let cholesky = Cholesky::new("prior covariance of the weights", covariance.to_owned())?;
    let factor = cholesky.factor();
    let n = factor.nrows();
    Ok(Mat::from_fn(n, n, |i, j| if i >= j { factor[(i, j)] } else { 0.0 }))
}

/// A B by one thread.
fn product(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Mat<f64> {
    let mut result = Mat::zeros(a.nrows(), b.ncols());
    matmul(result.as_mut(), Accum::Replace, a, b, 1.0, Par::Seq);
    result
}
