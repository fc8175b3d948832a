//! How learning a sparse process went.

use std::fmt;

use gp_core::{GpError, StopReason, write_hyperparameters};

/// What the optimiser did.
#[derive(Clone, Debug, PartialEq)]
pub struct SparseReport {
    /// Names of the hyperparameters, in the order of their values; the noise variance last.
    pub names: Vec<String>,
    /// Every start in order; an error where the objective does not exist at the start itself.
    pub starts: Vec<Result<SparseStart, GpError>>,
    /// The start that was taken: of those that converged, the one with the largest objective.
    pub best: SparseStart,
    /// Names of the hyperparameters that ended at a wall or bound.
    pub at_bound: Vec<String>,
    /// Pseudo-inputs in use; fewer than asked for where more would repeat them.
    pub n_pseudo_inputs: usize,
}

impl fmt::Display for SparseReport {
    /// The hyperparameters, each start, and what to look at twice.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_hyperparameters(f, &self.names, &self.best.parameters, &self.at_bound)?;
        writeln!(f, "{} pseudo-inputs", self.n_pseudo_inputs)?;
        for (i, start) in self.starts.iter().enumerate() {
            match start {
                Ok(start) => writeln!(
                    f,
                    "start {i}: objective {:.4}, gradient {:.1e}, {} iterations, {:?}",
                    start.objective, start.gradient_norm, start.iterations, start.stop
                )?,
                Err(error) => writeln!(f, "start {i}: {error}")?,
            }
        }
        Ok(())
    }
}

/// One start of the optimiser; hyperparameters in the user's units, the noise variance last.
#[derive(Clone, Debug, PartialEq)]
pub struct SparseStart {
    /// Hyperparameters at the start.
    pub start: Vec<f64>,
    /// Hyperparameters at the end.
    pub parameters: Vec<f64>,
    /// The objective at the end, in nats.
    pub objective: f64,
    /// Largest component of the gradient there.
    pub gradient_norm: f64,
    /// Quasi-Newton iterations.
    pub iterations: usize,
    /// Evaluations of the objective with its gradient.
    pub evaluations: usize,
    /// Why it stopped.
    pub stop: StopReason,
}
