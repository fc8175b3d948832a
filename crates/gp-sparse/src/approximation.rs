//! Which sparse approximation is made, as the two numbers in which they differ.

use gp_core::checks::check_not_negative;
use gp_core::{GpError, Mean};
use serde::{Deserialize, Serialize};

/// A sparse approximation of the exact process through its values at M pseudo-inputs.
///
/// All of them explain the data by N(y | m, Q + D), where Q = K_fu K_uu⁻¹ K_uf and D is diagonal,
/// and add a penalty for the variance c = diag(K − Q) that the pseudo-inputs leave over:
///
/// D = σₙ² + α c,  penalty = (1 − α)/(2α) Σ ln(1 + α cᵢ/σₙ²).
///
/// # Source
/// Bui, Yan & Turner, A unifying framework for Gaussian process pseudo-point approximations using
/// power expectation propagation (2017).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
#[non_exhaustive]
pub enum Approximation {
    /// α = 1: the sparse pseudo-input process (SPGP) of the thesis, eq. 3.19 to 3.25. Sharp
    /// predictions; tends to take noise for leftover variance and to underestimate the noise.
    ///
    /// # Source
    /// Snelson & Ghahramani, Sparse Gaussian processes using pseudo-inputs (2006).
    Fitc,
    /// α → 0: a lower bound of the exact log marginal likelihood, penalty Σ cᵢ/(2σₙ²). More
    /// pseudo-inputs never hurt; with too few of them the noise is overestimated.
    ///
    /// # Source
    /// Titsias, Variational learning of inducing variables in sparse Gaussian processes (2009).
    #[default]
    Vfe,
    /// α = 0 without the penalty: nothing keeps pseudo-inputs from overfitting. For comparison.
    ///
    /// # Source
    /// Seeger, Williams & Lawrence, Fast forward selection to speed up sparse Gaussian process
    /// regression (2003).
    Dtc,
    /// Between `Vfe` and `Fitc`.
    PowerEp {
        /// α, above 0 and at most 1.
        alpha: f64,
    },
}

impl Approximation {
    /// α.
    pub fn alpha(self) -> f64 {
        match self {
            Self::Fitc => 1.0,
            Self::Vfe | Self::Dtc => 0.0,
            Self::PowerEp { alpha } => alpha,
        }
    }

    /// Whether the leftover variance is penalised.
    pub(crate) fn has_penalty(self) -> bool {
        !matches!(self, Self::Dtc)
    }
}

/// What is chosen about a sparse process besides its parameters.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SparseSettings {
    /// The approximation.
    pub approximation: Approximation,
    /// The mean.
    pub mean: Mean,
    /// Variance of a noise on the pseudo-outputs over their prior variance, 0 or a little more.
    ///
    /// Pseudo-inputs closer than about a fifth of a lengthscale make K_uu singular to working
    /// precision, and smooth kernels bring them there. It is part of the model, so that bounds
    /// stay bounds.
    pub jitter: f64,
}

impl Default for SparseSettings {
    fn default() -> Self {
        Self { approximation: Approximation::Vfe, mean: Mean::Estimated, jitter: 1e-8 }
    }
}

impl SparseSettings {
    pub(crate) fn check(&self) -> Result<(), GpError> {
        if let Approximation::PowerEp { alpha } = self.approximation
            && !(alpha > 0.0 && alpha <= 1.0)
        {
            let name = "alpha of the approximation".to_owned();
            return Err(GpError::OutOfRange { name, value: alpha, lowest: 0.0, highest: 1.0 });
        }
        self.mean.check()?;
        check_not_negative("jitter", self.jitter)
    }
}
