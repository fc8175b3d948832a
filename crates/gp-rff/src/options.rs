//! How a process with random features is learnt.

use gp_core::{HyperPrior, Mean};

use crate::{FeatureOptions, Spectrum};

/// How a process with random features is learnt.
#[derive(Clone, Debug, PartialEq)]
pub struct RffOptions {
    /// The kernel that is approximated.
    pub spectrum: Spectrum,
    /// The features.
    pub features: FeatureOptions,
    /// Where lengthscales, signal and noise come from.
    pub hyperparameters: Hyperparameters,
    /// Rows of the exact process on a random part of the data, at most all.
    pub small_gp_rows: usize,
    /// Number of starts, at least 1: of the small process, and of the own likelihood beyond it.
    pub n_starts: usize,
    /// Seed of all that is drawn but the features.
    pub seed: u64,
    /// Most quasi-Newton iterations of one start.
    pub max_iterations: usize,
    /// Largest component of the gradient at convergence, in nats per log-parameter.
    pub gradient_tolerance: f64,
    /// The mean.
    pub mean: Mean,
    /// Known noise variance of each row beside the learnt common one, N, or none.
    pub row_noise: Vec<f64>,
    /// What is known of the hyperparameters before the data.
    pub prior: HyperPrior,
}

/// Where hyperparameters come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Hyperparameters {
    /// From the exact process on a few rows: the thesis. Fast; where the signal is far above the
    /// noise, features follow the kernel less closely than those parameters take for granted.
    SmallGp,
    /// From there on, the features' own marginal likelihood of all rows is maximised: O(N M²) a
    /// step, 24 N M bytes.
    #[default]
    OwnLikelihood,
    /// From there on, the frequencies are learnt with the rest, with the spectrum that they were drawn
    /// from as their prior: fewer features follow a function whose spectrum is its own.
    ///
    /// # Source
    /// Lázaro-Gredilla, Quiñonero-Candela, Rasmussen & Figueiras-Vidal, Sparse spectrum Gaussian process
    /// regression (2010), without a prior.
    Frequencies,
}

impl Default for RffOptions {
    fn default() -> Self {
        Self {
            spectrum: Spectrum::default(),
            features: FeatureOptions::default(),
            hyperparameters: Hyperparameters::default(),
            small_gp_rows: 300,
            n_starts: 2,
            seed: 0,
            max_iterations: 200,
            gradient_tolerance: 1e-2,
            mean: Mean::Estimated,
            row_noise: Vec::new(),
            prior: HyperPrior::Flat,
        }
    }
}
