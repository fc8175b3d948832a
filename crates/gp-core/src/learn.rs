//! Learning the hyperparameters of an exact Gaussian process from its marginal likelihood.

use std::sync::Arc;

use faer::MatRef;
use rayon::prelude::{IntoParallelIterator, ParallelIterator};

use crate::bfgs::{Limits, Minimum, best_of, minimize};
use crate::checks::{check_outputs, check_positive, check_row_noise};
use crate::constraints::hyperparameter_names;
use crate::kernel::check_kernel_and_inputs;
use crate::likelihood::Likelihood;
use crate::noise::Noise;
use crate::search_space::SearchSpace;
use crate::{Constraints, Gp, GpError, HyperPrior, Kernel, LearnReport, Mean, StartReport};

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

impl Gp {
    /// What the optimiser did; nothing where the hyperparameters were given.
    pub fn report(&self) -> Option<&LearnReport> {
        self.report.as_deref()
    }
}

/// Everything but the data.
pub(crate) struct Asked<'a> {
    pub(crate) kernel: &'a dyn Kernel,
    pub(crate) row_noise: &'a [f64],
    pub(crate) options: &'a LearnOptions,
    pub(crate) constraints: &'a Constraints,
}

impl Asked<'_> {
    pub(crate) fn learn(self, x: MatRef<'_, f64>, y: &[f64]) -> Result<Gp, GpError> {
        let Asked { kernel, row_noise, options, constraints } = self;
        check_learnable(kernel, x, y, options)?;
        check_row_noise(row_noise, y.len())?;
        let x = x.to_owned();
        let names = hyperparameter_names(kernel);
        let space = SearchSpace::new(kernel, x.as_ref(), y, options.prior);
        let space = space.constrained(&names, constraints)?;
        let search = Search { kernel, x: x.as_ref(), y, row_noise, space: &space, options };
        let ends: Vec<_> = (0..options.n_starts).into_par_iter().map(|i| search.run(i)).collect();
        let (best, minimum) = best_of(&ends)?;
        let (kernel_parameters, noise_variance) = split(space.parameters(&minimum.point));
        let learnt = Arc::from(kernel.with_parameters(&kernel_parameters)?);
        let noise = Noise { common: noise_variance, of_rows: row_noise };
        let mut gp = Gp::condition(learnt, x.as_ref(), y, noise, options.mean)?;
        let at_bound = space.at_bound(&minimum.point).into_iter().map(|i| names[i].clone());
        let at_bound = at_bound.collect();
        let report = |(i, end): (usize, &Result<Minimum, GpError>)| match end {
            Ok(minimum) => Ok(search.report(i, minimum)),
            Err(error) => Err(error.clone()),
        };
        let starts = ends.iter().enumerate().map(report).collect();
        let best = search.report(best, minimum);
        let report = LearnReport { names, starts, best, at_bound };
        gp.report = Some(Arc::new(report));
        Ok(gp)
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
        let mut by_parameters = vec![0.0; self.kernel.parameters().len() + 1];
        let limits = Limits {
            max_iterations: self.options.max_iterations,
            gradient_tolerance: self.options.gradient_tolerance,
            progress: None,
        };
        let objective = |point: &[f64], gradient: &mut [f64]| {
            let (parameters, noise_variance) = split(self.space.parameters(point));
            let kernel = self.kernel.with_parameters(&parameters)?;
            let noise = Noise { common: noise_variance, of_rows: self.row_noise };
            let value = likelihood.evaluate(&*kernel, noise, &mut by_parameters)?;
            by_parameters.iter_mut().for_each(|slope| *slope = -*slope);
            self.space.by_coordinates(point, &by_parameters, gradient);
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
            history: minimum.history.iter().map(|value| -value).collect(),
        }
    }
}

/// Checks that hyperparameters can be learnt from these data with these options.
///
/// # Errors
/// As [`GpBuilder::fit`](crate::GpBuilder::fit), but for what only the optimiser finds.
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
