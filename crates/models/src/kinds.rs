//! The list of all kinds of models.

use gp_core::LearnOptions;

use crate::{Analytical, GpPushModel, Hybrid, ModelError, PushModel, StepObservation};

/// A kind of model: its name, what it is, and how it is trained.
#[derive(Clone, Copy, Debug)]
pub struct ModelKind {
    /// The name in `model.toml`.
    pub id: &'static str,
    /// What it is, in a line.
    pub about: &'static str,
    /// Trains one on observed steps, from a nominal analytical model.
    pub train: Train,
}

/// Trains a model on observed steps, from a nominal analytical one.
pub type Train = fn(&Analytical, &[StepObservation]) -> Result<Box<dyn PushModel>, ModelError>;

/// Every kind of model.
pub fn model_kinds() -> &'static [ModelKind] {
    &KINDS
}

static KINDS: [ModelKind; 3] = [
    ModelKind {
        id: "analytical",
        about: "quasi-static push on an ellipsoidal limit surface, μp and c fitted",
        train: |nominal, steps| Ok(Box::new(nominal.fit(steps)?.model)),
    },
    ModelKind {
        id: "gp",
        about: "Gaussian processes from (p, β) to the motion",
        train: |_, steps| Ok(Box::new(GpPushModel::learn(steps, &LearnOptions::default())?.0)),
    },
    ModelKind {
        id: "hybrid",
        about: "fitted analytical model plus Gaussian processes on its residuals",
        train: |nominal, steps| {
            let fitted = nominal.fit(steps)?.model;
            Ok(Box::new(Hybrid::learn(fitted, steps, &LearnOptions::default())?.0))
        },
    },
];
