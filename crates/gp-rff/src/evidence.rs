//! Bayesian linear regression from sufficient statistics.

use std::f64::consts::PI;

use faer::Mat;
use gp_core::cholesky::{factorize, log_determinant};
use gp_core::triangle::{solve_lower, solve_upper};
use gp_core::vector::dot;
use gp_core::{GpError, Mean};

use crate::SufficientStatistics;

/// y − m = s Φ w + noise with w ~ N(0, I), conditioned on data; s² is the signal variance.
///
/// With Λ = s²ΦΦᵀ + σₙ² I and B = s²ΦᵀΦ + σₙ² I = R Rᵀ: σₙ² Λ⁻¹ = I − s²ΦB⁻¹Φᵀ, and
/// ln |Λ| = ln |B| + (N − M) ln σₙ².
pub(crate) struct Evidence {
    /// R.
    pub(crate) root: Mat<f64>,
    /// E(w) = t = s B⁻¹Φᵀ(y − m).
    pub(crate) weights: Vec<f64>,
    /// m less the origin.
    pub(crate) constant: f64,
    /// ln p(y), in nats.
    pub(crate) value: f64,
    /// |y − m − sΦt|².
    pub(crate) squared_residual: f64,
}

impl Evidence {
    /// # Errors
    /// `NotPositiveDefinite` if the noise variance is lost beside the signal's.
    pub(crate) fn new(
        statistics: &SufficientStatistics,
        signal_variance: f64,
        noise_variance: f64,
        mean: Mean,
    ) -> Result<Self, GpError> {
        let n = statistics.n_rows() as f64;
        let signal_sd = signal_variance.sqrt();
        let mut root = statistics.square() * signal_variance;
        let m = root.nrows();
        for j in 0..m {
            root[(j, j)] += noise_variance;
        }
        factorize("precision of the weights", root.as_mut())?;
        let scaled = |mut vector: Vec<f64>| {
            vector.iter_mut().for_each(|value| *value *= signal_sd);
            vector
        };
        let (mut of_one, mut of_y) = (scaled(statistics.of_one()), scaled(statistics.of_y()));
        solve_lower(root.as_ref(), &mut [&mut of_one, &mut of_y]);
        let one_one = n - dot(&of_one, &of_one);
        let one_y = statistics.one_y() - dot(&of_one, &of_y);
        let y_y = statistics.y_y() - dot(&of_y, &of_y);
        let constant = match mean {
            Mean::Fixed(value) => value - statistics.origin(),
            _ => one_y / one_one,
        };
        let quadratic = y_y - 2.0 * constant * one_y + constant * constant * one_one;
        let mut weights: Vec<f64> =
            of_y.iter().zip(&of_one).map(|(y, one)| y - constant * one).collect();
        solve_upper(root.as_ref(), &mut weights);
        let determinant = log_determinant(root.as_ref()) + (n - m as f64) * noise_variance.ln();
        let value = -0.5 * (quadratic / noise_variance + determinant + n * (2.0 * PI).ln());
        // rᵀ(I − P)r = |r − sΦt|² + σₙ²|t|² for the smoother P.
        let squared_residual = (quadratic - noise_variance * dot(&weights, &weights)).max(0.0);
        Ok(Self { root, weights, constant, value, squared_residual })
    }
}
