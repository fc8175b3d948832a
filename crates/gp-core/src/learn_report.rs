//! How learning an exact Gaussian process went.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::{GpError, StopReason};

/// What the optimiser did.
#[derive(Clone, Debug, PartialEq)]
pub struct LearnReport {
    /// Names of the hyperparameters, in the order of their values; the noise variance last.
    pub names: Vec<String>,
    /// Every start in order; an error where the likelihood does not exist at the start itself.
    pub starts: Vec<Result<StartReport, GpError>>,
    /// The start that was taken: of those that converged, the most likely (with the prior).
    pub best: StartReport,
    /// Names of the parameters that ended at a wall or bound, such as the lengthscale of an input
    /// without influence.
    pub at_bound: Vec<String>,
}

impl fmt::Display for LearnReport {
    /// The hyperparameters, each start, and what to look at twice.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_hyperparameters(f, &self.names, &self.best.parameters, &self.at_bound)?;
        for (i, start) in self.starts.iter().enumerate() {
            match start {
                Ok(start) => writeln!(
                    f,
                    "start {i}: ln p {:.4}, gradient {:.1e}, {} iterations, {:?}",
                    start.log_marginal_likelihood,
                    start.gradient_norm,
                    start.iterations,
                    start.stop
                )?,
                Err(error) => writeln!(f, "start {i}: {error}")?,
            }
        }
        Ok(())
    }
}

/// Writes a hyperparameter a line, and which of them ended at a bound.
///
/// # Errors
/// The writer's.
pub fn write_hyperparameters(
    f: &mut fmt::Formatter<'_>,
    names: &[String],
    values: &[f64],
    at_bound: &[String],
) -> fmt::Result {
    for (name, value) in names.iter().zip(values) {
        let note = if at_bound.contains(name) { "  (at its bound)" } else { "" };
        writeln!(f, "{name} = {value:.6}{note}")?;
    }
    Ok(())
}

/// One start of the optimiser; parameters in the user's units, the noise variance last.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StartReport {
    /// Where it started.
    pub start: Vec<f64>,
    /// Where it ended.
    pub parameters: Vec<f64>,
    /// ln p(y | X) there, in nats.
    pub log_marginal_likelihood: f64,
    /// Largest component of the gradient there, in nats per log-parameter.
    pub gradient_norm: f64,
    /// Quasi-Newton iterations.
    pub iterations: usize,
    /// Evaluations of the likelihood with its gradient.
    pub evaluations: usize,
    /// Why it stopped.
    pub stop: StopReason,
    /// What was maximised, at the start and after each iteration: ln p(y | X) and the prior's log density,
    /// in nats.
    pub history: Vec<f64>,
}
