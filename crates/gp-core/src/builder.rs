//! Putting an exact Gaussian process together.

use std::sync::Arc;

use crate::checks::check_row_noise;
use crate::constraints::hyperparameter_names;
use crate::learn::Asked;
use crate::noise::Noise;
use crate::{
    Constraints, Gp, GpError, Inputs, Kernel, LearnOptions, Mean, hyperparameters_by_name,
};

impl Gp {
    /// Begins a process with a kernel, a learnt constant mean, and nothing asked of its
    /// hyperparameters.
    pub fn builder(kernel: impl Kernel + 'static) -> GpBuilder {
        GpBuilder {
            kernel: Arc::new(kernel),
            noise_variance: None,
            row_noise: Vec::new(),
            options: LearnOptions::default(),
            constraints: Constraints::default(),
        }
    }
}

/// A process before it has seen data; `fit` learns its hyperparameters, `condition` keeps them.
///
/// Hyperparameters have names: those of [`Parameter`](crate::Parameter), and `noise_variance`. A name
/// without its index stands for all of them: `matern52.lengthscale` for `matern52.lengthscale[0]`,
/// `matern52.lengthscale[1]` and so on. Names are looked up by `fit` and `condition`.
#[derive(Clone, Debug)]
#[must_use]
pub struct GpBuilder {
    kernel: Arc<dyn Kernel>,
    noise_variance: Option<f64>,
    row_noise: Vec<f64>,
    options: LearnOptions,
    constraints: Constraints,
}

impl GpBuilder {
    /// The noise variance of `condition`, where 0 interpolates, and of the first start of `fit`; in the
    /// squared unit of the output.
    pub fn noise_variance(mut self, value: f64) -> Self {
        self.noise_variance = Some(value);
        self
    }

    /// Known noise variances of the rows, N, beside the common one.
    pub fn row_noise(mut self, variances: &[f64]) -> Self {
        self.row_noise = variances.to_vec();
        self
    }

    /// The mean; a learnt constant if it is not chosen.
    pub fn mean(mut self, mean: Mean) -> Self {
        self.options.mean = mean;
        self
    }

    /// How `fit` learns, and the mean.
    pub fn options(mut self, options: LearnOptions) -> Self {
        self.options = options;
        self
    }

    /// All that is asked by name, in place of what was asked before.
    pub fn constraints(mut self, constraints: Constraints) -> Self {
        self.constraints = constraints;
        self
    }

    /// Learns all kernel parameters and the noise variance by maximising ln p(y | X), in which a learnt
    /// mean is integrated out: unlike at its most likely value, noise is not underestimated where there
    /// are few rows for the coefficients.
    ///
    /// The kernel gives the family, and the start of periods and of parameters without unit; starts
    /// of lengthscales (√D times the spread of the input) and variances come from the data, but for
    /// those that are given by name.
    /// The optimiser works on standardised log-parameters, between wide walls that stop a runaway:
    /// lengthscales 0.01 to 100 √D times the input's spread, signal and noise variance 1e-6 to 1e6
    /// and 1e-8 to 10 times the output's, the others a factor of 1000 about their start. Between
    /// the walls nothing but the log prior is added to the likelihood; under a flat one, nothing.
    /// A bound of yours stands in place of the walls and is never left.
    /// The starts run in parallel; the result does not depend on the number of threads.
    ///
    /// # Errors
    /// As `condition`, but for `NoNoiseVariance`; what is wrong with names, ranges and ties:
    /// `UnknownParameter`, `OutOfRange`, `ShapeMismatch`, `Incompatible`; `TooFewRows` below two rows,
    /// or one more than learnt coefficients of the mean; `ConstantOutputs`, `NotConverged`.
    ///
    /// # Source
    /// Rasmussen & Williams, Gaussian Processes for Machine Learning (2006), ch. 5; the thesis,
    /// eq. 3.18.
    pub fn fit<'a>(&self, x: impl Into<Inputs<'a>>, y: &[f64]) -> Result<Gp, GpError> {
        let constraints = self.constraints.starting_at(self.noise_variance);
        let (kernel, row_noise, options) = (&*self.kernel, &*self.row_noise, &self.options);
        let asked = Asked { kernel, row_noise, options, constraints: &constraints };
        asked.learn(x.into().matrix(), y)
    }

    /// Learns with each of several settings, such as kernels or ranks of a coregionalisation, and takes the
    /// one with the largest ln p(y | X) − ½ k ln N, where k hyperparameters were free (the Bayesian
    /// information criterion); its place among them, and the process. The means have to be the same.
    ///
    /// # Errors
    /// As `fit`, of the first that fails; `Empty` without settings; `Incompatible` where means differ.
    ///
    /// # Source
    /// Schwarz, Estimating the dimension of a model (1978).
    pub fn fit_best<'a>(
        settings: &[Self],
        x: impl Into<Inputs<'a>>,
        y: &[f64],
    ) -> Result<(usize, Gp), GpError> {
        let x = x.into();
        if settings.windows(2).any(|pair| pair[0].options.mean != pair[1].options.mean) {
            return Err(GpError::Incompatible { what: "means of the settings" });
        }
        let mut best: Option<(f64, usize, Gp)> = None;
        for (place, one) in settings.iter().enumerate() {
            let gp = one.fit(x, y)?;
            let n_free = one.constraints.n_free(&hyperparameter_names(&*one.kernel))?;
            let penalty = 0.5 * n_free as f64 * (y.len() as f64).ln();
            let score = gp.log_marginal_likelihood() - penalty;
            if best.as_ref().is_none_or(|(most, ..)| score > *most) {
                best = Some((score, place, gp));
            }
        }
        let (_, place, gp) = best.ok_or(GpError::Empty { what: "settings" })?;
        Ok((place, gp))
    }

    /// Conditions the kernel on data with its parameters as they are; O(N³).
    ///
    /// - `x`: inputs, N×D; a single row is enough. - `y`: outputs, N.
    ///
    /// # Errors
    /// `NoNoiseVariance` if none is given; `Empty`, `ShapeMismatch`, `NotFinite`, `NotPositive`,
    /// `Negative`; `UnknownParameter` for a name that is none, `OutOfRange` for a value outside its
    /// bounds; `UndeterminedSlope` if the rows do not tell the slopes of a linear mean; `DuplicateRows`
    /// for equal inputs without noise; `NotPositiveDefinite` if the covariance is singular to working
    /// precision.
    pub fn condition<'a>(&self, x: impl Into<Inputs<'a>>, y: &[f64]) -> Result<Gp, GpError> {
        let (kernel, common) = self.constraints.apply(&*self.kernel, self.noise_variance)?;
        check_row_noise(&self.row_noise, y.len())?;
        let noise = Noise { common, of_rows: &self.row_noise };
        Gp::condition(Arc::from(kernel), x.into().matrix(), y, noise, self.options.mean)
    }
}

hyperparameters_by_name!(GpBuilder);
