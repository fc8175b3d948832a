//! A model as plain data: what goes into `model.toml` and its weights file, and what comes out of
//! them.

pub(crate) mod model_effect;
pub(crate) mod orthogonal_discrepancy;

use serde::{Deserialize, Serialize};

use crate::{
    Analytical, ModelEffect, ModelError, OrthogonalDiscrepancy, Outline, ProcessKind, ProcessModel,
    ProcessReport, SeenSteps, StepFeatures,
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
    /// [`crate::GpPushModel`] of this kind of process.
    Process(ProcessKind),
    /// [`crate::Hybrid`], on this analytical model.
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
    /// How each process was learnt; older weights do not tell.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub learning: Option<[ProcessReport; 3]>,
    /// Of a hybrid.
    #[serde(default, alias = "beside_physics", skip_serializing_if = "Option::is_none")]
    pub orthogonal_discrepancy: Option<OrthogonalDiscrepancy>,
}

impl Weights {
    /// The format that this release writes.
    pub const SCHEMA: &str = "pushlab.weights/4";

    /// The formats that it reads: before 3, `orthogonal_discrepancy` was `beside_physics`; before 4, there was
    /// no `learning`.
    pub(crate) const READABLE: [&str; 3] = ["pushlab.weights/2", "pushlab.weights/3", Self::SCHEMA];

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
