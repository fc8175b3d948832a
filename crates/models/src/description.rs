//! A model as plain data: what goes into `model.toml` and its weights file.

use gp_core::GpModel;
use serde::{Deserialize, Serialize};

use crate::{Analytical, GpPushModel, Hybrid, ModelEffect, ModelError, PushModel};

/// A model as plain data.
#[derive(Clone, Debug, PartialEq)]
pub struct Description {
    /// The kind with its parameters.
    pub base: Base,
    /// Effects that an analytical model carries, in the order of the file.
    pub effects: Vec<ModelEffect>,
    /// What was learnt, for the kinds that learn.
    pub weights: Option<Weights>,
}

/// The kind of a model with the parameters that people read.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Base {
    /// [`Analytical`].
    Analytical(Analytical),
    /// [`GpPushModel`].
    Gp,
    /// [`Hybrid`], on this analytical model.
    Hybrid(Analytical),
}

/// Three Gaussian processes, for Δx, Δy and Δθ per meter of the pusher's way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Weights {
    /// Name and version of this format.
    pub schema: String,
    /// One process an output.
    pub outputs: [GpModel; 3],
}

impl Weights {
    /// The format that this release writes and reads.
    pub const SCHEMA: &str = "pushlab.weights/1";
    /// The inputs of the processes, in order.
    pub const INPUTS: [&str; 2] = ["p", "beta_rad"];
}

impl Description {
    /// Builds the model of the motion alone.
    ///
    /// # Errors
    /// `EffectsNeedMore` for a model with effects: [`crate::ChannelModel`] predicts with them; `Gp`
    /// for weights that are missing or not usable.
    pub fn build(&self) -> Result<Box<dyn PushModel>, ModelError> {
        if !self.effects.is_empty() {
            let ids: Vec<_> = self.effects.iter().map(|effect| effect.id.as_str()).collect();
            return Err(ModelError::EffectsNeedMore { effects: ids.join(", ") });
        }
        let weights = || {
            self.weights.as_ref().ok_or(ModelError::Gp {
                output: "every output",
                source: gp_core::GpError::Empty { what: "weights" },
            })
        };
        Ok(match &self.base {
            Base::Analytical(analytical) => Box::new(analytical.clone()),
            Base::Gp => Box::new(GpPushModel::from_weights(weights()?)?),
            Base::Hybrid(analytical) => {
                Box::new(Hybrid::from_weights(analytical.clone(), weights()?)?)
            }
        })
    }
}
