//! The list of all kinds of models.

use gp_core::{HyperPrior, LearnOptions};

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

/// How the kinds learn: with a weak prior, which keeps the intervals of few steps honest.
///
/// By likelihood alone, most processes learnt from 20 real steps took their noise for a function
/// with a lengthscale below a tenth of the edge. Some hundred steps outweigh the prior.
pub fn learn_options() -> LearnOptions {
    let prior = HyperPrior::LogNormal { lengthscale_sd: 0.5, scale_sd: 1.0 };
    LearnOptions { prior, ..LearnOptions::default() }
}

static KINDS: [ModelKind; 3] = [
    ModelKind {
        id: "analytical",
        about: "quasi-static push on a limit surface, μp and c fitted",
        train: |nominal, steps| Ok(Box::new(nominal.fit(steps)?.model)),
    },
    ModelKind {
        id: "gp",
        about: "Gaussian processes from (p, β) to the motion",
        train: |_, steps| Ok(Box::new(GpPushModel::learn(steps, &learn_options())?.0)),
    },
    ModelKind {
        id: "hybrid",
        about: "fitted analytical model plus Gaussian processes on its residuals",
        train: |nominal, steps| {
            let fitted = nominal.fit(steps)?.model;
            Ok(Box::new(Hybrid::learn(fitted, steps, &learn_options())?.0))
        },
    },
];
