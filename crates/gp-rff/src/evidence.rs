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
/// ln |Λ| = ln |B| + (N − M) ln σₙ². A learnt m is a feature more, of a weight of which nothing is
/// known before the data; the value is then a density of what it does not touch, as in
/// [`gp_core::Gp::log_marginal_likelihood`].
pub(crate) struct Evidence {
    /// R.
    pub(crate) root: Mat<f64>,
    /// To y: c is m less the origin, t is E(w).
    pub(crate) mean: Response,
    /// To one standard deviation of a learnt mean: c = (1ᵀΛ⁻¹1)^−½.
    pub(crate) deviation: Option<Response>,
    /// ln p(y), in nats.
    pub(crate) value: f64,
}

/// What the regression makes of outputs r = b y − c 1, b = 1 or 0: at x it is c + s φ(x)ᵀt.
pub(crate) struct Response {
    /// b.
    pub(crate) of_y: f64,
    /// c.
    pub(crate) constant: f64,
    /// t = s B⁻¹Φᵀr.
    pub(crate) weights: Vec<f64>,
    /// |r − sΦt|².
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
        let (n, is_learnt) = (statistics.n_rows() as f64, mean.n_coefficients(0) > 0);
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
        // rᵀ(I − P)r for the smoother P is σₙ² rᵀΛ⁻¹r.
        let quadratic = y_y - 2.0 * constant * one_y + constant * constant * one_one;
        let response = |of_y_too: f64, constant: f64, quadratic: f64| {
            let pairs = of_y.iter().zip(&of_one);
            let mut weights: Vec<f64> =
                pairs.map(|(y, one)| of_y_too * y - constant * one).collect();
            solve_upper(root.as_ref(), &mut weights);
            // It is |r − sΦt|² + σₙ²|t|².
            let squared_residual = (quadratic - noise_variance * dot(&weights, &weights)).max(0.0);
            Response { of_y: of_y_too, constant, weights, squared_residual }
        };
        let mut determinant = log_determinant(root.as_ref()) + (n - m as f64) * noise_variance.ln();
        let (mean, mut deviation, mut n_told) = (response(1.0, constant, quadratic), None, n);
        if is_learnt {
            if one_one <= m as f64 * f64::EPSILON * n {
                let what = "precision of the mean";
                return Err(GpError::NotPositiveDefinite { what, size: 1, pivot: 0 });
            }
            let precision = one_one / noise_variance;
            deviation = Some(response(0.0, precision.sqrt().recip(), noise_variance));
            determinant += (precision / n).ln();
            n_told -= 1.0;
        }
        let value = -0.5 * (quadratic / noise_variance + determinant + n_told * (2.0 * PI).ln());
        Ok(Self { root, mean, deviation, value })
    }

    /// The mean's, and that of its deviation if it is learnt.
    pub(crate) fn responses(&self) -> impl Iterator<Item = &Response> {
        std::iter::once(&self.mean).chain(&self.deviation)
    }
}
