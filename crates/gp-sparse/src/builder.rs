//! Putting a sparse process together.

use std::sync::Arc;

use gp_core::checks::check_row_noise;
use gp_core::{Constraints, GpError, Inputs, Kernel, Mean, hyperparameters_by_name};

use crate::sparse_gp::check_data;
use crate::{Approximation, PseudoInputs, SparseGp, SparseOptions};

impl SparseGp {
    /// Begins a process with a kernel, the default options, and nothing asked of its hyperparameters.
    pub fn builder(kernel: impl Kernel + 'static) -> SparseGpBuilder {
        SparseGpBuilder {
            kernel: Arc::new(kernel),
            noise_variance: None,
            options: SparseOptions::default(),
            constraints: Constraints::default(),
        }
    }
}

/// A process before it has seen data; `fit` learns pseudo-inputs and hyperparameters, `condition` keeps
/// the hyperparameters.
///
/// Hyperparameters have names, as in [`gp_core::GpBuilder`]: those of
/// [`Parameter`](gp_core::Parameter), and `noise_variance`.
#[derive(Clone, Debug)]
#[must_use]
pub struct SparseGpBuilder {
    kernel: Arc<dyn Kernel>,
    noise_variance: Option<f64>,
    options: SparseOptions,
    constraints: Constraints,
}

impl SparseGpBuilder {
    /// The noise variance of `condition`, and where the exact process on a few rows starts in `fit`; in the
    /// squared unit of the output.
    pub fn noise_variance(mut self, value: f64) -> Self {
        self.noise_variance = Some(value);
        self
    }

    /// Known noise variances of the rows, N, beside the common one.
    pub fn row_noise(mut self, variances: &[f64]) -> Self {
        self.options.row_noise = variances.to_vec();
        self
    }

    /// The mean; a learnt constant if it is not chosen.
    pub fn mean(mut self, mean: Mean) -> Self {
        self.options.settings.mean = mean;
        self
    }

    /// The approximation; VFE if it is not chosen.
    pub fn approximation(mut self, approximation: Approximation) -> Self {
        self.options.settings.approximation = approximation;
        self
    }

    /// The pseudo-inputs; fifty learnt ones if they are not chosen.
    pub fn pseudo_inputs(mut self, pseudo_inputs: PseudoInputs) -> Self {
        self.options.pseudo_inputs = pseudo_inputs;
        self
    }

    /// All that can be chosen about the process and its learning, in place of what was chosen before.
    pub fn options(mut self, options: SparseOptions) -> Self {
        self.options = options;
        self
    }

    /// Learns as [`SparseGp::learn`]; [`SparseGp::report`] tells how.
    ///
    /// What is asked by name holds for the exact process on a few rows as well, from which all rows start:
    /// a start that is asked for is the start of that one.
    ///
    /// # Errors
    /// As [`SparseGp::learn`]; what is wrong with names, ranges and ties: `UnknownParameter`,
    /// `NotPositive`, `OutOfRange`, `ShapeMismatch`, `Incompatible`.
    pub fn fit<'a>(&self, x: impl Into<Inputs<'a>>, y: &[f64]) -> Result<SparseGp, GpError> {
        let constraints = self.constraints.starting_at(self.noise_variance);
        let data = (x.into().matrix(), y);
        Ok(SparseGp::learn_asked(&*self.kernel, data, &self.options, &constraints)?.0)
    }

    /// Conditions the kernel on data with its parameters as they are, and pseudo-inputs where they are
    /// given or placed; O(N M²).
    ///
    /// # Errors
    /// As [`SparseGp::fit_with_row_noise`]; `NoNoiseVariance` if none is given; `UnknownParameter` for a
    /// name that is none, `OutOfRange` for a value outside its bounds.
    pub fn condition<'a>(&self, x: impl Into<Inputs<'a>>, y: &[f64]) -> Result<SparseGp, GpError> {
        let (x, options) = (x.into().matrix(), &self.options);
        let (kernel, noise_variance) =
            self.constraints.apply(&*self.kernel, self.noise_variance)?;
        check_data(&*kernel, x, y)?;
        check_row_noise(&options.row_noise, y.len())?;
        options.settings.check()?;
        let z = options.pseudo_inputs.place(&*kernel, x, options.seed)?;
        let data = (x, y, &*options.row_noise);
        SparseGp::condition(Arc::from(kernel), data, &z, noise_variance, options.settings)
    }
}

hyperparameters_by_name!(SparseGpBuilder);
