//! A model as a search looks at it: the noise about it, and what it lacks.

use models::Description;

use super::DiagnoseSettings;
use super::phase::DiagnosePhase;
use crate::noise::widely_differing::At;
use crate::predict::tangent::Tangent;
use crate::remains::noise_beside;
use crate::screen::screen_at;
use crate::{DiagnosisError, NoiseModel, Observations, Screen, Whitening};

/// The noise about a model, its covariance and that of usual noise, and the test of what the model lacks.
pub(super) struct Linearised {
    pub(super) noise: NoiseModel,
    pub(super) whitening: Whitening,
    pub(super) usual: Whitening,
    pub(super) screen: Screen,
}

impl Linearised {
    pub(super) fn of(
        about: &Description,
        at: At,
        fitted: &Observations,
        settings: &DiagnoseSettings,
        observer: &dyn Fn(DiagnosePhase),
    ) -> Result<Self, DiagnosisError> {
        observer(DiagnosePhase::Noise);
        let mut tangent = Tangent::of(about, &settings.own, fitted)?;
        let usual = NoiseModel::usual_beside(about)?;
        let noise = noise_beside(&tangent, fitted, &settings.remain(), &usual)?;
        noise.put(&mut tangent.linearisation, at, (about, &settings.own), fitted)?;
        let whitening = noise.whitening_at(fitted, &tangent.linearisation)?;
        let usual = usual.whitening_at(fitted, &tangent.linearisation)?;
        observer(DiagnosePhase::Screening);
        let screen = screen_at(&tangent, fitted, &whitening, &settings.screen);
        Ok(Self { noise, whitening, usual, screen })
    }
}
