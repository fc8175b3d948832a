//! Learning the hyperparameters of an exact Gaussian process from its marginal likelihood.

use std::sync::Arc;

use faer::MatRef;
use rayon::prelude::{IntoParallelIterator, ParallelIterator};
use serde::{Deserialize, Serialize};

use crate::bfgs::{Limits, Minimum, StopReason, best_of, minimize};
use crate::checks::{check_count, check_outputs, check_positive};
use crate::kernel::check_kernel_and_inputs;
use crate::likelihood::Likelihood;
use crate::noise::{Noise, check_row_noise};
use crate::search_space::SearchSpace;
use crate::{Gp, GpError, HyperPrior, Kernel, Mean};

/// How hyperparameters are learnt; the default suits some hundred rows.
#[derive(Clone, Debug, PartialEq)]
pub struct LearnOptions {
    /// Number of starts, at least 1: the usual one, then a low-discrepancy set around it.
    pub n_starts: usize,
    /// Seed of the low-discrepancy set.
    pub seed: u64,
    /// Most quasi-Newton iterations of one start.
    pub max_iterations: usize,
    /// Largest component of the gradient at convergence, in nats per log-parameter.
    pub gradient_tolerance: f64,
    /// The mean.
    pub mean: Mean,
    /// What is known of the hyperparameters before the data.
    pub prior: HyperPrior,
}

impl Default for LearnOptions {
    fn default() -> Self {
        Self {
            n_starts: 4,
            seed: 0,
            max_iterations: 200,
            gradient_tolerance: 1e-3,
            mean: Mean::Estimated,
            prior: HyperPrior::Flat,
        }
    }
}

/// What the optimiser did.
#[derive(Clone, Debug, PartialEq)]
pub struct LearnReport {
    /// Every start in order; an error where the likelihood does not exist at the start itself.
    pub starts: Vec<Result<StartReport, GpError>>,
    /// The start that was taken: of those that converged, the most likely (with the prior).
    pub best: StartReport,
    /// Names of the parameters that ended at a wall, such as the lengthscale of an input without
    /// influence.
    pub at_bound: Vec<String>,
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
}

impl Gp {
    /// Learns all kernel parameters and the noise variance by maximising ln p(y | X), in which a learnt
    /// mean is integrated out: unlike at its most likely value, noise is not underestimated where there
    /// are few rows for the coefficients.
    ///
    /// `kernel` gives the family, and the start of periods and of parameters without unit; starts
    /// of lengthscales (√D times the spread of the input) and variances come from the data.
    /// The optimiser works on standardised log-parameters, between wide walls that stop a runaway:
    /// lengthscales 0.01 to 100 √D times the input's spread, signal and noise variance 1e-6 to 1e6
    /// and 1e-8 to 10 times the output's, the others a factor of 1000 about their start. Between
    /// the walls nothing but the log prior is added to the likelihood; under a flat one, nothing.
    /// The starts run in parallel; the result does not depend on the number of threads.
    ///
    /// # Errors
    /// As `fit`; `TooFewRows` below two rows, or one more than learnt coefficients of the mean;
    /// `ConstantOutputs`, `NotConverged`.
    ///
    /// # Source
    /// Rasmussen & Williams, Gaussian Processes for Machine Learning (2006), ch. 5; the thesis,
    /// eq. 3.18.
    pub fn learn(
        kernel: impl Kernel + 'static,
        x: MatRef<'_, f64>,
        y: &[f64],
        options: &LearnOptions,
    ) -> Result<(Self, LearnReport), GpError> {
        Self::learn_with_row_noise(kernel, x, y, &[], options)
    }

    /// As `learn`, where observations have known noise of their own beside the learnt common one.
    ///
    /// - `row_noise`: variance a row, N, or none.
    ///
    /// # Errors
    /// As `learn`; `Negative` for a noise that is.
    pub fn learn_with_row_noise(
        kernel: impl Kernel + 'static,
        x: MatRef<'_, f64>,
        y: &[f64],
        row_noise: &[f64],
        options: &LearnOptions,
    ) -> Result<(Self, LearnReport), GpError> {
        check_learnable(&kernel, x, y, options)?;
        if !row_noise.is_empty() {
            check_count("row noise", y.len(), row_noise.len())?;
            check_row_noise(row_noise)?;
        }
        let x = x.to_owned();
        let space = SearchSpace::new(&kernel, x.as_ref(), y, options.prior);
        let search =
            Search { kernel: &kernel, x: x.as_ref(), y, row_noise, space: &space, options };
        let ends: Vec<_> = (0..options.n_starts).into_par_iter().map(|i| search.run(i)).collect();
        let (best, minimum) = best_of(&ends)?;
        let (kernel_parameters, noise_variance) = split(space.parameters(&minimum.point));
        let learnt = Arc::from(kernel.with_parameters(&kernel_parameters)?);
        let noise = Noise { common: noise_variance, of_rows: row_noise };
        let gp = Self::condition(learnt, x.as_ref(), y, noise, options.mean)?;
        let mut names: Vec<String> = kernel.parameters().into_iter().map(|p| p.name).collect();
        names.push("noise_variance".to_owned());
        let at_bound =
            space.at_bound(&minimum.point).into_iter().map(|i| names[i].clone()).collect();
        let report = |(i, end): (usize, &Result<Minimum, GpError>)| match end {
            Ok(minimum) => Ok(search.report(i, minimum)),
            Err(error) => Err(error.clone()),
        };
        let starts = ends.iter().enumerate().map(report).collect();
        let best = search.report(best, minimum);
        Ok((gp, LearnReport { starts, best, at_bound }))
    }
}

/// One optimisation problem, shared by all starts.
struct Search<'a> {
    kernel: &'a dyn Kernel,
    x: MatRef<'a, f64>,
    y: &'a [f64],
    row_noise: &'a [f64],
    space: &'a SearchSpace,
    options: &'a LearnOptions,
}

impl Search<'_> {
    /// Minimises the negative log marginal likelihood from start number `index`.
    fn run(&self, index: usize) -> Result<Minimum, GpError> {
        let mut likelihood = Likelihood::new(self.x, self.y, self.options.mean);
        let limits = Limits {
            max_iterations: self.options.max_iterations,
            gradient_tolerance: self.options.gradient_tolerance,
            progress: None,
        };
        let objective = |point: &[f64], gradient: &mut [f64]| {
            let (parameters, noise_variance) = split(self.space.parameters(point));
            let kernel = self.kernel.with_parameters(&parameters)?;
            let noise = Noise { common: noise_variance, of_rows: self.row_noise };
            let value = likelihood.evaluate(&*kernel, noise, gradient)?;
            gradient.iter_mut().for_each(|slope| *slope = -*slope);
            let total = self.space.penalty(point, gradient) - value;
            check_outputs("log marginal likelihood", &[total], 1)?;
            check_outputs("gradient of the log marginal likelihood", gradient, point.len())?;
            Ok(total)
        };
        minimize(objective, &self.space.start(index, self.options.seed), limits)
    }

    fn report(&self, index: usize, minimum: &Minimum) -> StartReport {
        let penalty = self.space.penalty(&minimum.point, &mut vec![0.0; minimum.point.len()]);
        StartReport {
            start: self.space.parameters(&self.space.start(index, self.options.seed)),
            parameters: self.space.parameters(&minimum.point),
            log_marginal_likelihood: penalty - minimum.value,
            gradient_norm: minimum.gradient_norm,
            iterations: minimum.iterations,
            evaluations: minimum.evaluations,
            stop: minimum.stop,
        }
    }
}

/// Checks that hyperparameters can be learnt from these data with these options.
///
/// # Errors
/// As [`Gp::learn`], but for what only the optimiser finds.
pub fn check_learnable(
    kernel: &dyn Kernel,
    x: MatRef<'_, f64>,
    y: &[f64],
    options: &LearnOptions,
) -> Result<(), GpError> {
    check_kernel_and_inputs(kernel, x)?;
    check_outputs("outputs", y, x.nrows())?;
    check_positive("n_starts", options.n_starts as f64)?;
    check_positive("gradient_tolerance", options.gradient_tolerance)?;
    if let HyperPrior::LogNormal { lengthscale_sd, scale_sd } = options.prior {
        check_positive("lengthscale_sd of the prior", lengthscale_sd)?;
        check_positive("scale_sd of the prior", scale_sd)?;
    }
    options.mean.check()?;
    let needed = 2.max(1 + options.mean.n_coefficients(x.ncols()));
    if y.len() < needed {
        return Err(GpError::TooFewRows { needed, actual: y.len() });
    }
    if y.iter().all(|value| *value == y[0]) {
        return Err(GpError::ConstantOutputs { value: y[0], n_rows: y.len() });
    }
    Ok(())
}

/// The kernel's parameters and the noise variance, which comes last.
fn split(mut parameters: Vec<f64>) -> (Vec<f64>, f64) {
    let noise_variance = parameters.pop().expect("the noise variance is always there");
    (parameters, noise_variance)
}
