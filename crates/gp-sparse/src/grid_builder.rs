//! Putting a process on a grid together.

use std::sync::Arc;

use gp_core::{Constraints, GpError, Inputs, Kernel, Mean, hyperparameters_by_name};

use crate::{GridGp, GridOptions};

impl GridGp {
    /// Begins a process with a kernel, the default options, and nothing asked of its hyperparameters.
    pub fn builder(kernel: impl Kernel + 'static) -> GridGpBuilder {
        GridGpBuilder {
            kernel: Arc::new(kernel),
            noise_variance: None,
            options: GridOptions::default(),
            constraints: Constraints::default(),
        }
    }
}

/// A process before it has seen data; `fit` learns its hyperparameters, `condition` keeps them.
///
/// Hyperparameters have names, as in [`gp_core::GpBuilder`]: those of
/// [`Parameter`](gp_core::Parameter), and `noise_variance`.
#[derive(Clone, Debug)]
#[must_use]
pub struct GridGpBuilder {
    kernel: Arc<dyn Kernel>,
    noise_variance: Option<f64>,
    options: GridOptions,
    constraints: Constraints,
}

impl GridGpBuilder {
    /// The noise variance of `condition`, and where the exact process on a few rows starts in `fit`; in the
    /// squared unit of the output.
    pub fn noise_variance(mut self, value: f64) -> Self {
        self.noise_variance = Some(value);
        self
    }

    /// The mean; a learnt constant if it is not chosen.
    pub fn mean(mut self, mean: Mean) -> Self {
        self.options.mean = mean;
        self
    }

    /// All that can be chosen about the process and its learning, in place of what was chosen before.
    pub fn options(mut self, options: GridOptions) -> Self {
        self.options = options;
        self
    }

    /// Learns as [`GridGp::learn`]; [`GridGp::report`] tells how. A start that is asked for is that of the
    /// exact process on a few rows.
    ///
    /// # Errors
    /// As [`GridGp::learn`]; what is wrong with names, ranges and ties: `UnknownParameter`,
    /// `NotPositive`, `OutOfRange`, `ShapeMismatch`, `Incompatible`.
    pub fn fit<'a>(&self, x: impl Into<Inputs<'a>>, y: &[f64]) -> Result<GridGp, GpError> {
        let constraints = self.constraints.starting_at(self.noise_variance);
        let data = (x.into().matrix(), y);
        Ok(GridGp::learn_asked(&*self.kernel, data, &self.options, &constraints)?.0)
    }

    /// Conditions the kernel on data with its parameters as they are.
    ///
    /// # Errors
    /// As [`GridGp::fit`]; `NoNoiseVariance` if none is given; `UnknownParameter` for a name that is none,
    /// `OutOfRange` for a value outside its bounds.
    pub fn condition<'a>(&self, x: impl Into<Inputs<'a>>, y: &[f64]) -> Result<GridGp, GpError> {
        let (kernel, noise_variance) =
            self.constraints.apply(&*self.kernel, self.noise_variance)?;
        GridGp::fit(kernel, x.into().matrix(), y, noise_variance, &self.options)
    }
}

hyperparameters_by_name!(GridGpBuilder);
