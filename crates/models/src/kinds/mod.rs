//! A description goes in, a pushing model comes out: the trait, the kinds, and their list.

pub(crate) mod analytical;
pub(crate) mod build;
pub(crate) mod hybrid;
pub(crate) mod physics;
pub(crate) mod processes;
pub(crate) mod push_model;

use crate::{
    Analytical, GpPushModel, Hybrid, ModelError, ProcessKind, PushModel, StepObservation, Training,
};

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

static KINDS: [ModelKind; 6] = [
    ModelKind {
        id: "analytical",
        about: "quasi-static push on a limit surface, μp and c fitted",
        train: |nominal, steps| Ok(Box::new(nominal.fit(steps)?.model)),
    },
    ModelKind {
        id: "gp",
        about: "Gaussian processes from (p, β) to the motion",
        train: |_, steps| process(ProcessKind::Gp, steps),
    },
    ModelKind {
        id: "spgp",
        about: "sparse Gaussian processes with learnt pseudo-inputs",
        train: |_, steps| process(ProcessKind::Spgp, steps),
    },
    ModelKind {
        id: "rff",
        about: "Bayesian linear regression on random Fourier features",
        train: |_, steps| process(ProcessKind::Rff, steps),
    },
    ModelKind {
        id: "vhgp",
        about: "Gaussian processes whose noise is a function of (p, β) too",
        train: |_, steps| process(ProcessKind::Vhgp, steps),
    },
    ModelKind {
        id: "hybrid",
        about: "fitted analytical model with effects, plus any of the processes, orthogonal to it",
        train: |nominal, steps| {
            let (base, training) = (nominal.describe()?, Training::default());
            Ok(Box::new(Hybrid::train(&base, None, steps, &training)?.0))
        },
    },
];

fn process(kind: ProcessKind, steps: &[StepObservation]) -> Result<Box<dyn PushModel>, ModelError> {
    Ok(Box::new(GpPushModel::train(steps, &Training::with(kind))?.0))
}
