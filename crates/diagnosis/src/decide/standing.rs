//! Where the last model stands on a part of the set.

use super::DiagnoseSettings;
use super::found::Found;
use crate::{DiagnosisError, Observations, Predictions, Whitening};

/// The last model, with its nuisances, on observations.
pub(super) struct Standing<'a> {
    pub(super) observations: &'a Observations,
    /// Expected of pushes that differ as the noise says.
    pub(super) predictions: Predictions,
    /// Observed less predicted.
    pub(super) residuals: Vec<[Option<f64>; 7]>,
    pub(super) whitening: Whitening,
}

impl<'a> Standing<'a> {
    pub(super) fn of(
        found: &Found,
        observations: &'a Observations,
        settings: &DiagnoseSettings,
    ) -> Result<Self, DiagnosisError> {
        let (model, own) = (&found.with_nuisances, &settings.own);
        let whitening = found.noise.whitening_from(found.at, model, own, observations)?;
        let predictions = Predictions::expected(model, own, observations)?.about(whitening.mean());
        let residuals = predictions.residuals(observations)?;
        Ok(Self { observations, predictions, residuals, whitening })
    }
}
