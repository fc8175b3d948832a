//! How a learnt model is trained.

use gp_core::{HyperPrior, LearnOptions};

use crate::{ProcessKind, StepFeatures};

/// What is learnt, from what, and how; the default is the exact process of (p, β).
#[derive(Clone, Debug, PartialEq)]
pub struct Training {
    /// The process of each output.
    pub process: ProcessKind,
    /// Its inputs.
    pub features: StepFeatures,
    /// Pseudo-inputs of [`ProcessKind::Spgp`]; no more than there are steps.
    pub n_pseudo_inputs: usize,
    /// Features of [`ProcessKind::Rff`].
    pub n_features: usize,
    /// Prior, starts and seed.
    pub options: LearnOptions,
}

impl Training {
    /// The default with another process.
    pub fn with(process: ProcessKind) -> Self {
        Self { process, ..Self::default() }
    }
}

impl Default for Training {
    fn default() -> Self {
        learn_options().into()
    }
}

impl From<LearnOptions> for Training {
    fn from(options: LearnOptions) -> Self {
        Self {
            process: ProcessKind::default(),
            features: StepFeatures::default(),
            n_pseudo_inputs: 50,
            n_features: 200,
            options,
        }
    }
}

/// How the kinds learn: with a weak prior, which keeps the intervals of few steps honest.
///
/// By likelihood alone, most processes learnt from 20 real steps took their noise for a function
/// with a lengthscale below a tenth of the edge. Some hundred steps outweigh the prior.
pub fn learn_options() -> LearnOptions {
    let prior = HyperPrior::LogNormal { lengthscale_sd: 0.5, scale_sd: 1.0 };
    LearnOptions { prior, ..LearnOptions::default() }
}
