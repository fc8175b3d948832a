//! How a sparse process is learnt.

use faer::MatRef;
use gp_core::checks::{check_inputs, check_positive, check_row_noise};
use gp_core::{GpError, HyperPrior, Kernel, LearnOptions, check_learnable};

use crate::{Approximation, Optimizer, Placement, PseudoInputs, SparseSettings};

/// How a sparse process is learnt.
#[derive(Clone, Debug, PartialEq)]
pub struct SparseOptions {
    /// The approximation, the mean and the jitter.
    pub settings: SparseSettings,
    /// The pseudo-inputs.
    pub pseudo_inputs: PseudoInputs,
    /// Known noise variance of each row beside the learnt common one, N, or none.
    pub row_noise: Vec<f64>,
    /// Rows of the exact process on a random part of the data from which hyperparameters start.
    pub warm_start_rows: usize,
    /// Number of starts, at least 1: the warm one, then a low-discrepancy set of hyperparameters.
    pub n_starts: usize,
    /// Seed of all that is drawn.
    pub seed: u64,
    /// Most quasi-Newton iterations of one start.
    pub max_iterations: usize,
    /// Largest component of the gradient at convergence, in nats per unit.
    pub gradient_tolerance: f64,
    /// Converged as well where ten iterations together gain less than this, in nats: the best
    /// places of pseudo-inputs form a flat valley.
    pub progress_tolerance: f64,
    /// What is known of the hyperparameters before the data.
    pub prior: HyperPrior,
    /// How pseudo-inputs and hyperparameters are moved.
    pub optimizer: Optimizer,
}

impl Default for SparseOptions {
    fn default() -> Self {
        Self {
            settings: SparseSettings::default(),
            pseudo_inputs: PseudoInputs::Learnt { count: 50, placement: Placement::default() },
            row_noise: Vec::new(),
            warm_start_rows: 200,
            n_starts: 1,
            seed: 0,
            max_iterations: 1000,
            gradient_tolerance: 1e-3,
            progress_tolerance: 0.1,
            prior: HyperPrior::Flat,
            optimizer: Optimizer::QuasiNewton,
        }
    }
}

impl SparseOptions {
    pub(crate) fn check(
        &self,
        kernel: &dyn Kernel,
        x: MatRef<'_, f64>,
        y: &[f64],
    ) -> Result<(), GpError> {
        let learning = LearnOptions {
            n_starts: self.n_starts,
            gradient_tolerance: self.gradient_tolerance,
            mean: self.settings.mean,
            prior: self.prior,
            ..LearnOptions::default()
        };
        check_learnable(kernel, x, y, &learning)?;
        self.settings.check()?;
        check_row_noise(&self.row_noise, y.len())?;
        check_positive("progress_tolerance", self.progress_tolerance)?;
        if let Optimizer::Stochastic(batches) = self.optimizer {
            batches.check()?;
            if self.settings.approximation != Approximation::Vfe {
                let what = "approximation and what batches of rows add up to, which is VFE,";
                return Err(GpError::Incompatible { what });
            }
        }
        match &self.pseudo_inputs {
            PseudoInputs::Given(z) => check_inputs("pseudo-inputs", z.as_ref(), x.ncols()),
            _ => Ok(()),
        }
    }
}
