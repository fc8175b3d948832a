//! Bayesian linear regression from sufficient statistics.

use std::f64::consts::PI;

use faer::{Mat, MatRef};
use gp_core::cholesky::{factorize, log_determinant};
use gp_core::triangle::{solve_lower, solve_upper};
use gp_core::vector::dot;
use gp_core::{GeneralizedLeastSquares, GpError, Mean, Monomials};

use crate::SufficientStatistics;

/// y − m = s Φ w + noise with w ~ N(0, I), conditioned on data; s² is the signal variance.
///
/// Noise is N(0, σₙ² W⁻¹), with weights W of 1 but for rows that have noise of their own. With
/// Λ = s²ΦΦᵀ + σₙ² W⁻¹ and B = s²ΦᵀWΦ + σₙ² I = R Rᵀ: σₙ² Λ⁻¹ = W − s²WΦB⁻¹ΦᵀW, and
/// ln |Λ| = ln |B| + (N − M) ln σₙ² − ln |W|. A learnt m is some features more, of weights of which nothing
/// is known before the data; the value is then a density of what they do not touch, as in
/// [`gp_core::Gp::log_marginal_likelihood`].
pub(crate) struct Evidence {
    /// R.
    pub(crate) root: Mat<f64>,
    /// To y: c is that of m less the origin, t is E(w).
    pub(crate) mean: Response,
    /// To one standard deviation of each direction of a learnt mean.
    pub(crate) deviations: Vec<Response>,
    /// What m is a sum of.
    pub(crate) monomials: Monomials,
    /// ln p(y), in nats.
    pub(crate) value: f64,
}

/// What the regression makes of outputs r = b y − H c, b = 1 or 0: at x it is h(x)ᵀc + s φ(x)ᵀt.
pub(crate) struct Response {
    /// b.
    pub(crate) of_y: f64,
    /// c.
    pub(crate) coefficients: Vec<f64>,
    /// t = s B⁻¹ΦᵀWr.
    pub(crate) weights: Vec<f64>,
    /// eᵀWe of e = r − sΦt.
    pub(crate) squared_residual: f64,
}

impl Response {
    /// - `known`: R⁻¹sΦᵀW(y, H); - `quadratic`: σₙ² rᵀΛ⁻¹r.
    fn solve(
        (of_y, coefficients): (f64, Vec<f64>),
        known: &[Vec<f64>],
        root: MatRef<'_, f64>,
        (quadratic, noise_variance): (f64, f64),
    ) -> Self {
        let mut weights: Vec<f64> = known[0].iter().map(|y| of_y * y).collect();
        for (coefficient, basis) in coefficients.iter().zip(&known[1..]) {
            weights.iter_mut().zip(basis).for_each(|(weight, one)| *weight -= coefficient * one);
        }
        solve_upper(root, &mut weights);
        // It is eᵀWe + σₙ²|t|².
        let squared_residual = (quadratic - noise_variance * dot(&weights, &weights)).max(0.0);
        Self { of_y, coefficients, weights, squared_residual }
    }
}

impl Evidence {
    /// - `n_inputs`: D.
    ///
    /// # Errors
    /// `NotPositiveDefinite` if the noise variance is lost beside the signal's; `UndeterminedSlope`;
    /// `Incompatible` for a mean of which the statistics have no sums.
    pub(crate) fn new(
        statistics: &SufficientStatistics,
        signal_variance: f64,
        noise_variance: f64,
        (mean, n_inputs): (Mean, usize),
    ) -> Result<Self, GpError> {
        let whole = statistics.monomials(n_inputs);
        let degree = mean.degree().unwrap_or(0);
        if degree > whole.degree() {
            return Err(GpError::Incompatible {
                what: "degrees of the mean and of the statistics",
            });
        }
        let monomials = Monomials::new(degree, whole.center());
        let n_basis = monomials.count();
        let signal_sd = signal_variance.sqrt();
        let mut root = statistics.square() * signal_variance;
        let m = root.nrows();
        for j in 0..m {
            root[(j, j)] += noise_variance;
        }
        factorize("precision of the weights", root.as_mut())?;
        // R⁻¹sΦᵀW(y, H).
        let mut known = statistics.of_outputs(n_basis);
        known.iter_mut().flatten().for_each(|value| *value *= signal_sd);
        let mut vectors: Vec<&mut [f64]> = known.iter_mut().map(Vec::as_mut_slice).collect();
        solve_lower(root.as_ref(), &mut vectors);
        let mut products = statistics.products(n_basis);
        let whole: Vec<f64> = (1..=n_basis).map(|k| products[(k, k)]).collect();
        for (j, b) in known.iter().enumerate() {
            known.iter().enumerate().skip(j).for_each(|(i, a)| products[(i, j)] -= dot(a, b));
        }
        let (products, n_rows) = (products.as_ref(), statistics.n_rows() as usize);
        let told = GeneralizedLeastSquares::new(products, noise_variance, &monomials, n_rows)?;
        let respond = |of_y, coefficients, quadratic| {
            Response::solve(
                (of_y, coefficients),
                &known,
                root.as_ref(),
                (quadratic, noise_variance),
            )
        };
        let coefficients = match mean {
            Mean::Fixed(value) => vec![value - statistics.origin()],
            _ => told.best().to_vec(),
        };
        let quadratic = told.quadratic(&coefficients);
        let n = n_rows as f64;
        let mut determinant = log_determinant(root.as_ref()) + (n - m as f64) * noise_variance.ln()
            - statistics.log_weights();
        let (mut deviations, mut n_told) = (Vec::new(), n);
        if mean.degree().is_some() {
            let directions = told.deviations(&whole, m)?.into_iter();
            deviations = directions.map(|one| respond(0.0, one, noise_variance)).collect();
            determinant += told.log_determinant(statistics.spread(n_basis).as_ref())?;
            n_told -= n_basis as f64;
        }
        let value = -0.5 * (quadratic / noise_variance + determinant + n_told * (2.0 * PI).ln());
        let mean = respond(1.0, coefficients, quadratic);
        Ok(Self { mean, deviations, value, root, monomials })
    }

    /// The mean's, and those of its deviations if it is learnt.
    pub(crate) fn responses(&self) -> impl Iterator<Item = &Response> {
        std::iter::once(&self.mean).chain(&self.deviations)
    }
}
