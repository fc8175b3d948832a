//! A model as plain data: what goes into `model.toml` and its weights file.

use dataset::SupportSpec;
use effects::Effect;
use serde::{Deserialize, Serialize};

use crate::physics::Physics;
use crate::physics_model::PhysicsModel;
use crate::{
    Analytical, BesidePhysics, GpPushModel, Hybrid, ModelEffect, ModelError, Outline, ProcessKind,
    ProcessModel, PushModel, SeenSteps, Setup, StepFeatures,
};

/// A model as plain data.
#[derive(Clone, Debug, PartialEq)]
pub struct Description {
    /// The kind with its parameters.
    pub base: Base,
    /// Effects that the mechanics carry, in the order of the file.
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
    /// [`GpPushModel`] of this kind of process.
    Process(ProcessKind),
    /// [`Hybrid`], on this analytical model.
    Hybrid(Analytical),
}

/// Three processes, for Δx, Δy and Δθ per meter of the pusher's way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Weights {
    /// Name and version of this format.
    pub schema: String,
    /// The inputs of the processes, in order.
    pub inputs: Vec<String>,
    /// The objects that were learnt about.
    pub outlines: Vec<Outline>,
    /// One process an output, all of one kind.
    pub outputs: [ProcessModel; 3],
    /// What the training steps span; older weights do not tell.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seen: Option<SeenSteps>,
    /// Of a hybrid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub beside_physics: Option<BesidePhysics>,
}

impl Weights {
    /// The format that this release writes and reads.
    pub const SCHEMA: &str = "pushlab.weights/2";

    /// The inputs as a choice.
    ///
    /// # Errors
    /// `UnsoundWeights` for other names.
    pub fn features(&self) -> Result<StepFeatures, ModelError> {
        let unsound = ModelError::UnsoundWeights { what: "inputs" };
        StepFeatures::by_names(&self.inputs).ok_or(unsound)
    }

    /// The kind of the processes.
    pub fn kind(&self) -> ProcessKind {
        self.outputs[0].kind()
    }
}

impl Description {
    /// Builds the model of the motion alone.
    ///
    /// # Errors
    /// `EffectsNeedMore` for a model with effects: an analytical one predicts with them as a
    /// [`crate::ChannelModel`], a hybrid as [`Description::build_in`] builds it; `NoWeights`, or
    /// `Gp` for weights that are not usable.
    pub fn build(&self) -> Result<Box<dyn PushModel>, ModelError> {
        self.built(None)
    }

    /// Builds the model in a set-up, which the effects of a hybrid act in; `own` are effects besides
    /// the catalogue's. Such a hybrid is asked about whole steps ([`crate::StepInput::of`]).
    ///
    /// # Errors
    /// As [`Description::build`].
    pub fn build_in(
        &self,
        support: SupportSpec,
        own: &[&'static dyn Effect],
    ) -> Result<Box<dyn PushModel>, ModelError> {
        self.built(Some(Setup { support, own: own.to_vec() }))
    }

    fn built(&self, setup: Option<Setup>) -> Result<Box<dyn PushModel>, ModelError> {
        let weights = || self.weights.as_ref().ok_or(ModelError::NoWeights);
        Ok(match &self.base {
            Base::Analytical(analytical) if self.effects.is_empty() => Box::new(analytical.clone()),
            Base::Analytical(analytical) if setup.is_some() => {
                let effects = self.effects.clone();
                Box::new(PhysicsModel(Physics::new(analytical.clone(), effects, setup)?))
            }
            Base::Analytical(_) => {
                let ids: Vec<_> = self.effects.iter().map(|effect| effect.id.as_str()).collect();
                return Err(ModelError::EffectsNeedMore { effects: ids.join(", ") });
            }
            Base::Process(_) => Box::new(GpPushModel::from_weights(weights()?)?),
            Base::Hybrid(analytical) => {
                let physics = Physics::new(analytical.clone(), self.effects.clone(), setup)?;
                Box::new(Hybrid::from_weights(physics, weights()?)?)
            }
        })
    }
}
