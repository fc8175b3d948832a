//! Priors of single hyperparameters.

use std::fmt::Debug;

use crate::GpError;
use crate::checks::{check_outputs, check_positive};

/// What is known of one hyperparameter before the data.
///
/// Learning finds the most likely logarithm of it: a density p(θ) counts as θ p(θ), its density of ln θ,
/// so that the unit of θ does not matter.
pub trait Prior: Debug + Send + Sync {
    /// The log density of ln θ at θ, up to a constant, in nats, and its slope by ln θ.
    fn log_density(&self, value: f64) -> (f64, f64);
}

/// ln θ ~ N(μ, s²).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LogNormal {
    log_median: f64,
    log_sd: f64,
}

impl LogNormal {
    /// - `log_median`: μ, with the median e^μ in the unit of the hyperparameter.
    /// - `log_sd`: s, positive.
    ///
    /// # Errors
    /// `NotFinite`, `NotPositive`.
    pub fn new(log_median: f64, log_sd: f64) -> Result<Self, GpError> {
        check_outputs("log median of the prior", &[log_median], 1)?;
        check_positive("log_sd of the prior", log_sd)?;
        Ok(Self { log_median, log_sd })
    }
}

impl Prior for LogNormal {
    fn log_density(&self, value: f64) -> (f64, f64) {
        let deviation = (value.ln() - self.log_median) / self.log_sd;
        (-0.5 * deviation * deviation, -deviation / self.log_sd)
    }
}

/// p(θ) ∝ θᵃ⁻¹ e^−bθ, with mean a/b: few large values, and none near 0 where a is large.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gamma {
    shape: f64,
    rate: f64,
}

impl Gamma {
    /// - `shape`: a; - `rate`: b, in one over the unit of the hyperparameter.
    ///
    /// # Errors
    /// `NotPositive`.
    pub fn new(shape: f64, rate: f64) -> Result<Self, GpError> {
        check_positive("shape of the prior", shape)?;
        check_positive("rate of the prior", rate)?;
        Ok(Self { shape, rate })
    }
}

impl Prior for Gamma {
    fn log_density(&self, value: f64) -> (f64, f64) {
        let scaled = self.rate * value;
        (self.shape * value.ln() - scaled, self.shape - scaled)
    }
}

/// p(θ) ∝ θ^−a−1 e^−b/θ, with mean b/(a − 1): next to no values near 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InverseGamma {
    shape: f64,
    scale: f64,
}

impl InverseGamma {
    /// - `shape`: a; - `scale`: b, in the unit of the hyperparameter.
    ///
    /// # Errors
    /// `NotPositive`.
    pub fn new(shape: f64, scale: f64) -> Result<Self, GpError> {
        check_positive("shape of the prior", shape)?;
        check_positive("scale of the prior", scale)?;
        Ok(Self { shape, scale })
    }
}

impl Prior for InverseGamma {
    fn log_density(&self, value: f64) -> (f64, f64) {
        let scaled = self.scale / value;
        (-self.shape * value.ln() - scaled, scaled - self.shape)
    }
}
