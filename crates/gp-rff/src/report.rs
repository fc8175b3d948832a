//! How learning a process with random features went.

use std::fmt;

use gp_core::{StopReason, write_hyperparameters};

/// What was learnt and how; parameters are lengthscales, signal variance and noise variance.
#[derive(Clone, Debug, PartialEq)]
pub struct RffReport {
    /// Names of the parameters, in the order of their values; the noise variance last.
    pub names: Vec<String>,
    /// Parameters of the small exact process.
    pub small_gp: Vec<f64>,
    /// Parameters in use.
    pub parameters: Vec<f64>,
    /// Quasi-Newton iterations on the own likelihood; 0 with `SmallGp`.
    pub iterations: usize,
    /// Evaluations of the own likelihood with its gradient.
    pub evaluations: usize,
    /// Why the taken start stopped; none with `SmallGp`.
    pub stop: Option<StopReason>,
    /// Names of the parameters that the own likelihood drove to a wall or bound.
    pub at_bound: Vec<String>,
}

impl fmt::Display for RffReport {
    /// The hyperparameters, and how the optimiser ended.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_hyperparameters(f, &self.names, &self.parameters, &self.at_bound)?;
        match self.stop {
            Some(stop) => writeln!(f, "{} iterations, {stop:?}", self.iterations),
            None => writeln!(f, "those of the exact process on a few rows"),
        }
    }
}
