//! Bayesian linear regression as plain data that can be saved and loaded.

use faer::{Mat, MatRef};
use serde::{Deserialize, Serialize};

use crate::checks::{check_outputs, check_positive};
use crate::{BayesianLinear, Cholesky, GpError, saved_as};

/// Everything from which `BayesianLinear::from_model` rebuilds the same predictions, bit for bit.
///
/// It holds M² + 2M numbers, however many rows were learnt from.
/// A text format has to keep all digits (with `serde_json`: its feature `float_roundtrip`).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BayesianLinearModel {
    /// Version of this format.
    pub version: u32,
    /// The posterior mean of the weights, M.
    pub weights: Vec<f64>,
    /// Noise variance, in the squared unit of the output.
    pub noise_variance: f64,
    /// ln p(y | Φ), in nats.
    pub log_evidence: f64,
    /// L with Σp = L Lᵀ, lower triangle by rows.
    pub prior_factor: Vec<f64>,
    /// R with LᵀΦᵀΦL + σₙ² I = R Rᵀ, lower triangle by rows.
    pub precision_factor: Vec<f64>,
}

impl BayesianLinearModel {
    /// The version that this release writes and reads.
    pub const VERSION: u32 = 1;
}

impl BayesianLinear {
    /// The regression as plain data.
    pub fn to_model(&self) -> BayesianLinearModel {
        BayesianLinearModel {
            version: BayesianLinearModel::VERSION,
            weights: self.weights.clone(),
            noise_variance: self.noise_variance,
            log_evidence: self.log_evidence,
            prior_factor: rows(self.prior_factor.as_ref()),
            precision_factor: rows(self.cholesky.factor()),
        }
    }

    /// The regression that `to_model` described.
    ///
    /// # Errors
    /// `UnsupportedVersion`; `Empty`, `ShapeMismatch`, `NotFinite`, `NotPositive`, since a file may have
    /// been edited.
    pub fn from_model(model: &BayesianLinearModel) -> Result<Self, GpError> {
        let (found, supported) = (model.version, BayesianLinearModel::VERSION);
        if found != supported {
            return Err(GpError::UnsupportedVersion { found, supported });
        }
        let m = model.weights.len();
        if m == 0 {
            return Err(GpError::Empty { what: "weights" });
        }
        check_outputs("weights", &model.weights, m)?;
        check_positive("noise variance", model.noise_variance)?;
        check_outputs("log evidence", &[model.log_evidence], 1)?;
        let prior = Cholesky::from_factor(lower("prior factor", &model.prior_factor, m)?)?;
        let precision = lower("precision factor", &model.precision_factor, m)?;
        Ok(Self {
            prior_factor: prior.factor().to_owned(),
            cholesky: Cholesky::from_factor(precision)?,
            weights: model.weights.clone(),
            noise_variance: model.noise_variance,
            log_evidence: model.log_evidence,
        })
    }
}

saved_as!(BayesianLinear => BayesianLinearModel, |regression| Ok(regression.to_model()));

/// The lower triangle by rows.
fn rows(matrix: MatRef<'_, f64>) -> Vec<f64> {
    (0..matrix.nrows()).flat_map(|i| (0..=i).map(move |j| matrix[(i, j)])).collect()
}

/// A lower triangle by rows, and zeros above it.
fn lower(what: &'static str, rows: &[f64], m: usize) -> Result<Mat<f64>, GpError> {
    check_outputs(what, rows, m * (m + 1) / 2)?;
    Ok(Mat::from_fn(m, m, |i, j| if j <= i { rows[i * (i + 1) / 2 + j] } else { 0.0 }))
}
