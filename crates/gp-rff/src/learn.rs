//! Learning lengthscales, signal and noise.

use faer::{Mat, MatRef};
use gp_core::bfgs::{Limits, Minimum, best_of, minimize};
use gp_core::checks::check_outputs;
use gp_core::{
    Gp, GpError, HyperPrior, Kernel, LearnOptions, Mean, SearchSpace, StopReason, check_learnable,
};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::{IntoParallelIterator, ParallelIterator};

use crate::likelihood::Likelihood;
use crate::{FeatureOptions, RandomFeatures, RffGp, Spectrum, SufficientStatistics};

/// How a process with random features is learnt.
#[derive(Clone, Debug, PartialEq)]
pub struct RffOptions {
    /// The kernel that is approximated.
    pub spectrum: Spectrum,
    /// The features.
    pub features: FeatureOptions,
    /// Where lengthscales, signal and noise come from.
    pub hyperparameters: Hyperparameters,
    /// Rows of the exact process on a random part of the data, at most all.
    pub small_gp_rows: usize,
    /// Number of starts, at least 1: of the small process, and of the own likelihood beyond it.
    pub n_starts: usize,
    /// Seed of all that is drawn but the features.
    pub seed: u64,
    /// Most quasi-Newton iterations of one start.
    pub max_iterations: usize,
    /// Largest component of the gradient at convergence, in nats per log-parameter.
    pub gradient_tolerance: f64,
    /// The constant mean.
    pub mean: Mean,
    /// What is known of the hyperparameters before the data.
    pub prior: HyperPrior,
}

/// Where hyperparameters come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Hyperparameters {
    /// From the exact process on a few rows: the thesis. Fast; where the signal is far above the
    /// noise, features follow the kernel less closely than those parameters take for granted.
    SmallGp,
    /// From there on, the features' own marginal likelihood of all rows is maximised: O(N M²) a
    /// step, 24 N M bytes.
    #[default]
    OwnLikelihood,
}

impl Default for RffOptions {
    fn default() -> Self {
        Self {
            spectrum: Spectrum::default(),
            features: FeatureOptions::default(),
            hyperparameters: Hyperparameters::default(),
            small_gp_rows: 300,
            n_starts: 2,
            seed: 0,
            max_iterations: 200,
            gradient_tolerance: 1e-2,
            mean: Mean::Estimated,
            prior: HyperPrior::Flat,
        }
    }
}

/// What was learnt and how; parameters are lengthscales, signal variance and noise variance.
#[derive(Clone, Debug, PartialEq)]
pub struct RffReport {
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
    /// Names of the parameters that the own likelihood drove to a wall.
    pub at_bound: Vec<String>,
}

impl RffGp {
    /// Draws features and learns lengthscales, signal variance and noise variance.
    ///
    /// The result does not depend on the number of threads.
    ///
    /// # Errors
    /// As `fit` and [`RandomFeatures::new`]; `TooFewRows` below two rows, `ConstantOutputs`,
    /// `NotConverged`.
    pub fn learn(
        x: MatRef<'_, f64>,
        y: &[f64],
        options: &RffOptions,
    ) -> Result<(Self, RffReport), GpError> {
        let kernel = options.spectrum.kernel(&vec![1.0; x.ncols()], 1.0)?;
        check_learnable(&*kernel, x, y, &small_options(options))?;
        options.mean.check_constant()?;
        let small_gp = small_process(&*kernel, x, y, options)?;
        let d = x.ncols();
        let features = RandomFeatures::new(options.spectrum, &small_gp[..d], options.features)?;
        let mut report = RffReport {
            parameters: small_gp.clone(),
            small_gp,
            iterations: 0,
            evaluations: 0,
            stop: None,
            at_bound: Vec::new(),
        };
        if options.hyperparameters == Hyperparameters::OwnLikelihood {
            maximize_own(&*kernel, &features, x, y, options, &mut report)?;
        }
        let features = features.with_lengthscales(&report.parameters[..d])?;
        let origin = y.iter().sum::<f64>() / y.len() as f64;
        let mut statistics = SufficientStatistics::new(&features, origin)?;
        statistics.update(&features, x, y)?;
        let (signal, noise) = (report.parameters[d], report.parameters[d + 1]);
        let gp = Self::from_statistics(features, statistics, signal, noise, options.mean)?;
        Ok((gp, report))
    }

    /// ∂ ln p(y)/∂ ln θ for the lengthscales, the signal variance and the noise variance; O(N M²).
    ///
    /// # Errors
    /// As `fit`.
    pub fn log_evidence_gradient(
        &self,
        x: MatRef<'_, f64>,
        y: &[f64],
    ) -> Result<Vec<f64>, GpError> {
        let mut evaluator = self.evaluator(x, y)?;
        evaluator.evaluate()?;
        Ok(evaluator.gradient().to_vec())
    }
}

/// Moves the report's parameters to the maximum of the features' own likelihood.
fn maximize_own(
    kernel: &dyn Kernel,
    features: &RandomFeatures,
    x: MatRef<'_, f64>,
    y: &[f64],
    options: &RffOptions,
    report: &mut RffReport,
) -> Result<(), GpError> {
    let d = x.ncols();
    let space = SearchSpace::new(kernel, x, y, options.prior);
    let limits = Limits {
        max_iterations: options.max_iterations,
        gradient_tolerance: options.gradient_tolerance,
        progress: None,
    };
    let run = |index: usize| {
        let mut likelihood = Likelihood::new(features, x, y, options.mean)?;
        let evaluate = |point: &[f64], gradient: &mut [f64]| {
            let parameters = space.parameters(point);
            let moved = features.with_lengthscales(&parameters[..d])?;
            let value = likelihood.evaluate(&moved, parameters[d], parameters[d + 1], gradient)?;
            gradient.iter_mut().for_each(|slope| *slope = -*slope);
            let total = space.penalty(point, gradient) - value;
            check_outputs("log evidence", &[total], 1)?;
            check_outputs("gradient of the log evidence", gradient, point.len())?;
            Ok(total)
        };
        let start = match index {
            0 => space.point(&report.small_gp),
            _ => space.start(index, options.seed),
        };
        minimize(evaluate, &start, limits)
    };
    let ends: Vec<Result<Minimum, GpError>> =
        (0..options.n_starts).into_par_iter().map(run).collect();
    let (_, best) = best_of(&ends)?;
    let mut names: Vec<String> = kernel.parameters().into_iter().map(|p| p.name).collect();
    names.push("noise_variance".to_owned());
    report.parameters = space.parameters(&best.point);
    report.iterations = best.iterations;
    report.evaluations = best.evaluations;
    report.stop = Some(best.stop);
    report.at_bound = space.at_bound(&best.point).into_iter().map(|i| names[i].clone()).collect();
    Ok(())
}

/// Hyperparameters of the exact process on a random part of the rows.
fn small_process(
    kernel: &dyn Kernel,
    x: MatRef<'_, f64>,
    y: &[f64],
    options: &RffOptions,
) -> Result<Vec<f64>, GpError> {
    let mut rows: Vec<usize> = (0..y.len()).collect();
    rows.shuffle(&mut ChaCha8Rng::seed_from_u64(options.seed));
    rows.truncate(options.small_gp_rows);
    let few = Mat::from_fn(rows.len(), x.ncols(), |i, d| x[(rows[i], d)]);
    let few_y: Vec<f64> = rows.iter().map(|&row| y[row]).collect();
    let values: Vec<f64> = kernel.parameters().iter().map(|parameter| parameter.value).collect();
    let family = kernel.with_parameters(&values)?;
    let gp = Gp::builder(family).options(small_options(options)).fit(few.as_ref(), &few_y)?;
    Ok(gp.hyperparameters().into_iter().map(|(_, value)| value).collect())
}

fn small_options(options: &RffOptions) -> LearnOptions {
    LearnOptions {
        n_starts: options.n_starts,
        seed: options.seed,
        max_iterations: options.max_iterations,
        gradient_tolerance: options.gradient_tolerance,
        mean: options.mean,
        prior: options.prior,
    }
}
