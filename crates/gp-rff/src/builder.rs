//! Putting a process with random features together.

use gp_core::checks::check_count;
use gp_core::{Constraints, GpError, Inputs, Mean, hyperparameters_by_name};

use crate::learn::Asked;
use crate::{RandomFeatures, RffGp, RffOptions, Spectrum};

impl RffGp {
    /// Begins a process with a kernel, the default options, and nothing asked of its hyperparameters.
    pub fn builder(spectrum: Spectrum) -> RffGpBuilder {
        RffGpBuilder {
            noise_variance: None,
            options: RffOptions { spectrum, ..RffOptions::default() },
            constraints: Constraints::default(),
            features: None,
        }
    }
}

/// A process before it has seen data; `fit` learns its hyperparameters, `condition` keeps them.
///
/// Hyperparameters have names, as in [`gp_core::GpBuilder`]: those of the kernel, such as
/// `squared_exponential.lengthscale[0]`, and `noise_variance`. A signal variance that `condition` is not
/// given is 1, and so are lengthscales, but for those of given features.
#[derive(Clone, Debug)]
#[must_use]
pub struct RffGpBuilder {
    noise_variance: Option<f64>,
    options: RffOptions,
    constraints: Constraints,
    features: Option<RandomFeatures>,
}

impl RffGpBuilder {
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
        self.options.mean = mean;
        self
    }

    /// How many features are drawn; 200 if it is not chosen.
    pub fn n_features(mut self, n_features: usize) -> Self {
        self.options.features.n_features = n_features;
        self
    }

    /// Features that are given, in place of those that would be drawn; `fit` learns their lengthscales.
    pub fn features(mut self, features: RandomFeatures) -> Self {
        self.features = Some(features);
        self
    }

    /// All that can be chosen about the process and its learning, in place of what was chosen before, the
    /// kernel too.
    pub fn options(mut self, options: RffOptions) -> Self {
        self.options = options;
        self
    }

    /// Learns as [`RffGp::learn`]; [`RffGp::report`] tells how. What is asked by name holds for the exact
    /// process on a few rows as well; a start that is asked for is the start of that one.
    ///
    /// # Errors
    /// As [`RffGp::learn`]; what is wrong with names, ranges and ties: `UnknownParameter`,
    /// `NotPositive`, `OutOfRange`, `ShapeMismatch`, `Incompatible`.
    pub fn fit<'a>(&self, x: impl Into<Inputs<'a>>, y: &[f64]) -> Result<RffGp, GpError> {
        let constraints = self.constraints.starting_at(self.noise_variance);
        let (options, features) = (&self.options, self.features.as_ref());
        let asked = Asked { options, constraints: &constraints, features };
        Ok(asked.learn(x.into().matrix(), y)?.0)
    }

    /// Conditions on data with hyperparameters as they are asked for; O(N M²).
    ///
    /// # Errors
    /// As [`RffGp::fit_with`] and [`RandomFeatures::new`]; `NoNoiseVariance` if none is given;
    /// `UnknownParameter` for a name that is none, `OutOfRange` for a value outside its bounds.
    pub fn condition<'a>(&self, x: impl Into<Inputs<'a>>, y: &[f64]) -> Result<RffGp, GpError> {
        let (x, options) = (x.into().matrix(), &self.options);
        let d = x.ncols();
        let lengthscales = match &self.features {
            Some(given) => given.lengthscales().to_vec(),
            None => vec![1.0; d],
        };
        check_count("columns of the inputs", lengthscales.len(), d)?;
        let kernel = options.spectrum.kernel(&lengthscales, 1.0)?;
        let (kernel, noise_variance) = self.constraints.apply(&*kernel, self.noise_variance)?;
        let values: Vec<f64> = kernel.parameters().iter().map(|one| one.value).collect();
        let features = match &self.features {
            Some(given) => given.with_lengthscales(&values[..d])?,
            None => RandomFeatures::new(options.spectrum, &values[..d], options.features)?,
        };
        let data = (x, y, &*options.row_noise);
        RffGp::fit_with(features, data, values[d], noise_variance, options.mean)
    }
}

hyperparameters_by_name!(RffGpBuilder);
