//! A process with random features as plain data that can be saved and loaded.

use gp_core::checks::{check_count, check_finite};
use gp_core::{GpError, Mean, saved_as};
use serde::{Deserialize, Serialize};

use crate::{Form, RandomFeatures, RffGp, Spectrum, SufficientStatistics};

/// Everything from which `RffGp::from_model` rebuilds the same predictions, bit for bit, and goes
/// on taking in rows.
///
/// It holds M² + M D numbers, however many rows were learnt from.
/// A text format has to keep all digits (with `serde_json`: its feature `float_roundtrip`).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RffGpModel {
    /// Version of this format.
    pub version: u32,
    /// The kernel that is approximated.
    pub spectrum: Spectrum,
    /// What a frequency is turned into.
    pub form: Form,
    /// Lengthscales, each in the unit of its input.
    pub lengthscales: Vec<f64>,
    /// Frequencies for lengthscales of 1, one a vector.
    pub frequencies: Vec<Vec<f64>>,
    /// One phase a frequency, in rad; 0 where both cosine and sine are features.
    pub phases: Vec<f64>,
    /// In the squared unit of the output.
    pub signal_variance: f64,
    /// In the squared unit of the output.
    pub noise_variance: f64,
    /// The constant mean; an estimated one is estimated again.
    pub mean: Mean,
    /// What is kept of the data.
    pub statistics: SufficientStatistics,
}

impl RffGpModel {
    /// The version that this release writes and reads.
    pub const VERSION: u32 = 1;
}

saved_as!(RffGp => RffGpModel, |process| Ok(process.to_model()));

impl RffGp {
    /// The process as plain data.
    pub fn to_model(&self) -> RffGpModel {
        let features = self.features();
        let rows = features.frequencies.chunks_exact(features.n_inputs());
        RffGpModel {
            version: RffGpModel::VERSION,
            spectrum: features.spectrum,
            form: features.form,
            lengthscales: features.lengthscales.clone(),
            frequencies: rows.map(<[f64]>::to_vec).collect(),
            phases: features.phases.clone(),
            signal_variance: self.signal_variance,
            noise_variance: self.noise_variance,
            mean: self.mean,
            statistics: self.statistics.clone(),
        }
    }

    /// The process that `to_model` described.
    ///
    /// # Errors
    /// `UnsupportedVersion`; else as `from_statistics`, since a file may have been edited.
    pub fn from_model(model: &RffGpModel) -> Result<Self, GpError> {
        if model.version != RffGpModel::VERSION {
            let supported = RffGpModel::VERSION;
            return Err(GpError::UnsupportedVersion { found: model.version, supported });
        }
        model.spectrum.kernel(&model.lengthscales, 1.0)?;
        if model.frequencies.is_empty() {
            return Err(GpError::Empty { what: "frequencies" });
        }
        for frequency in &model.frequencies {
            check_count("coordinates of a frequency", model.lengthscales.len(), frequency.len())?;
        }
        check_count("phases", model.frequencies.len(), model.phases.len())?;
        let features = RandomFeatures {
            spectrum: model.spectrum,
            form: model.form,
            lengthscales: model.lengthscales.clone(),
            frequencies: model.frequencies.concat(),
            phases: model.phases.clone(),
        };
        for (what, numbers) in
            [("frequencies", &features.frequencies), ("phases", &features.phases)]
        {
            let row = faer::MatRef::from_row_major_slice(numbers, 1, numbers.len());
            check_finite(what, row)?;
        }
        let statistics = model.statistics.clone();
        let (signal, noise) = (model.signal_variance, model.noise_variance);
        Self::from_statistics(features, statistics, signal, noise, model.mean)
    }
}
