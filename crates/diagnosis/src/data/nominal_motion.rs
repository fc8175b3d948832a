//! Observed motions beside those of a nominal push.

use dataset::SupportSpec;
use models::{Analytical, Base, ChannelModel, ChannelObservation, Description, ModelError};

use crate::DiagnosisError;

/// Observed and predicted Δx, Δy (m) and Δθ (rad) of a step.
pub(crate) type Beside = [(f64, f64); 3];

/// Motions by an ellipsoid of uniform pressure with a pusher's friction.
pub(crate) struct NominalMotion(ChannelModel);

impl NominalMotion {
    /// On a table.
    ///
    /// # Errors
    /// `Model` for a friction, of pusher or table, that no model can have.
    pub(crate) fn new(pusher_friction: f64, support: SupportSpec) -> Result<Self, DiagnosisError> {
        let nominal = Description {
            base: Base::Analytical(Analytical::nominal(pusher_friction)?),
            effects: Vec::new(),
            weights: None,
        };
        Ok(Self(ChannelModel::new(&nominal, support, &[])?))
    }

    /// None for a step that the mechanics refuse, which says nothing of others, or of unknown motion.
    ///
    /// # Errors
    /// `Model` for what else is refused.
    pub(crate) fn beside(
        &self,
        step: &ChannelObservation,
    ) -> Result<Option<Beside>, DiagnosisError> {
        let predicted = match self.0.predict([&step.input]) {
            Ok(channels) => channels,
            Err(ModelError::Effects(_)) => return Ok(None),
            Err(error) => return Err(error.into()),
        };
        let Some(at) = predicted.first().map(effects::Channels::to_array) else { return Ok(None) };
        let [Some(x), Some(y), Some(theta)] = [0, 1, 2].map(|k| step.observed[k]) else {
            return Ok(None);
        };
        Ok(Some([(x, at[0]), (y, at[1]), (theta, at[2])]))
    }
}
