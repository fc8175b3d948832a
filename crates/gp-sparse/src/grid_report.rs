//! How learning a process on a grid went.

use std::fmt;

use gp_core::{StopReason, write_hyperparameters};

/// What the optimiser did; hyperparameters in the user's units, the noise variance last.
#[derive(Clone, Debug, PartialEq)]
pub struct GridReport {
    /// Names of the hyperparameters.
    pub names: Vec<String>,
    /// Where it started: those of the exact process on a few rows.
    pub start: Vec<f64>,
    /// Where it ended.
    pub parameters: Vec<f64>,
    /// ln p(y | X) there, in nats.
    pub log_marginal_likelihood: f64,
    /// Largest component of the gradient there.
    pub gradient_norm: f64,
    /// Quasi-Newton iterations.
    pub iterations: usize,
    /// Evaluations of the likelihood with its gradient.
    pub evaluations: usize,
    /// Why it stopped.
    pub stop: StopReason,
    /// Names of the parameters that ended at a wall.
    pub at_bound: Vec<String>,
    /// Nodes in use.
    pub n_nodes: usize,
    /// Spacing of the nodes over the learnt lengthscale, in the input where it is widest: above about a
    /// half the interpolation shows.
    pub widest_spacing: f64,
}

impl fmt::Display for GridReport {
    /// The hyperparameters, the nodes, and how the optimiser ended.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_hyperparameters(f, &self.names, &self.parameters, &self.at_bound)?;
        writeln!(
            f,
            "{} nodes, at most {:.2} of a lengthscale apart",
            self.n_nodes, self.widest_spacing
        )?;
        writeln!(
            f,
            "ln p {:.4}, gradient {:.1e}, {} iterations, {:?}",
            self.log_marginal_likelihood, self.gradient_norm, self.iterations, self.stop
        )
    }
}
