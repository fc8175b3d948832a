//! Learning lengthscales, signal and noise.

use faer::{Mat, MatRef};
use gp_core::bfgs::{Limits, Minimum, best_of, minimize};
use gp_core::checks::{check_inputs, check_outputs};
use gp_core::{
    Gp, GpError, HyperPrior, LearnOptions, Mean, SearchSpace, StopReason, check_learnable,
};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::{IntoParallelRefIterator, ParallelIterator};

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
    /// From there on, the frequencies are learnt with the rest, with the spectrum that they were drawn
    /// from as their prior: fewer features follow a function whose spectrum is its own.
    ///
    /// # Source
    /// Lázaro-Gredilla, Quiñonero-Candela, Rasmussen & Figueiras-Vidal, Sparse spectrum Gaussian process
    /// regression (2010), without a prior.
    Frequencies,
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
        let small_gp = small_process(x, y, options)?;
        let d = x.ncols();
        let features = RandomFeatures::new(options.spectrum, &small_gp[..d], options.features)?;
        learn_from(features, small_gp, x, y, options)
    }

    /// As `learn`, with features that are given: of a spectrum of your own
    /// ([`RandomFeatures::with_frequencies`]), or those of another process. The options' own features
    /// are not drawn; their spectrum is that of the small process.
    ///
    /// # Errors
    /// As `learn`.
    pub fn learn_with(
        features: RandomFeatures,
        x: MatRef<'_, f64>,
        y: &[f64],
        options: &RffOptions,
    ) -> Result<(Self, RffReport), GpError> {
        check_inputs("inputs", x, features.n_inputs())?;
        let small_gp = small_process(x, y, options)?;
        let features = features.with_lengthscales(&small_gp[..x.ncols()])?;
        learn_from(features, small_gp, x, y, options)
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

/// Learns all that is asked for from the small process on.
fn learn_from(
    mut features: RandomFeatures,
    small_gp: Vec<f64>,
    x: MatRef<'_, f64>,
    y: &[f64],
    options: &RffOptions,
) -> Result<(RffGp, RffReport), GpError> {
    let d = x.ncols();
    let mut report = RffReport {
        parameters: small_gp.clone(),
        small_gp,
        iterations: 0,
        evaluations: 0,
        stop: None,
        at_bound: Vec::new(),
    };
    if options.hyperparameters != Hyperparameters::SmallGp {
        let learnt = Own::new(&features, x, y, options)?.maximize(&mut report)?;
        features.frequencies = learnt;
    }
    let features = features.with_lengthscales(&report.parameters[..d])?;
    let origin = y.iter().sum::<f64>() / y.len() as f64;
    let mut statistics = SufficientStatistics::new(&features, origin)?;
    statistics.update(&features, x, y)?;
    let (signal, noise) = (report.parameters[d], report.parameters[d + 1]);
    let gp = RffGp::from_statistics(features, statistics, signal, noise, options.mean)?;
    Ok((gp, report))
}

/// The maximum of the features' own likelihood, from several starts.
struct Own<'a> {
    features: &'a RandomFeatures,
    x: MatRef<'a, f64>,
    y: &'a [f64],
    options: &'a RffOptions,
    space: SearchSpace,
    names: Vec<String>,
}

impl<'a> Own<'a> {
    fn new(
        features: &'a RandomFeatures,
        x: MatRef<'a, f64>,
        y: &'a [f64],
        options: &'a RffOptions,
    ) -> Result<Self, GpError> {
        let kernel = options.spectrum.kernel(&vec![1.0; x.ncols()], 1.0)?;
        let space = SearchSpace::new(&*kernel, x, y, options.prior);
        let mut names: Vec<String> = kernel.parameters().into_iter().map(|p| p.name).collect();
        names.push("noise_variance".to_owned());
        Ok(Self { features, x, y, options, space, names })
    }

    /// Moves the report's parameters there; the frequencies, learnt if they are to be.
    fn maximize(&self, report: &mut RffReport) -> Result<Vec<f64>, GpError> {
        let start = |index: usize| match index {
            0 => self.space.point(&report.small_gp),
            _ => self.space.start(index, self.options.seed),
        };
        let starts: Vec<_> = (0..self.options.n_starts).map(start).collect();
        let run = |start: &Vec<f64>| self.minimize(start);
        let ends: Vec<Result<Minimum, GpError>> = starts.par_iter().map(run).collect();
        let (_, best) = best_of(&ends)?;
        self.tell(best, report);
        if self.options.hyperparameters == Hyperparameters::Frequencies {
            let mut start = best.point.clone();
            start.extend(&self.features.frequencies);
            let ends = [self.minimize(&start)];
            let (_, best) = best_of(&ends)?;
            self.tell(best, report);
            return Ok(best.point[self.names.len()..].to_vec());
        }
        Ok(self.features.frequencies.clone())
    }

    /// From standardised hyperparameters, and from frequencies behind them if they are to move.
    fn minimize(&self, start: &[f64]) -> Result<Minimum, GpError> {
        let Self { features, x, y, options, space, names } = self;
        let (d, n) = (x.ncols(), names.len());
        let progress = (start.len() > n).then_some((10, PROGRESS));
        let limits = Limits {
            max_iterations: options.max_iterations.max(if start.len() > n { 1000 } else { 0 }),
            gradient_tolerance: options.gradient_tolerance,
            progress,
        };
        let mut likelihood = Likelihood::new(features, *x, y, options.mean)?;
        let evaluate = |point: &[f64], gradient: &mut [f64]| {
            let (standardized, frequencies) = point.split_at(n);
            let parameters = space.parameters(standardized);
            let mut moved = features.with_lengthscales(&parameters[..d])?;
            if !frequencies.is_empty() {
                moved.frequencies = frequencies.to_vec();
            }
            let value = likelihood.evaluate(&moved, parameters[d], parameters[d + 1], gradient)?;
            gradient.iter_mut().for_each(|slope| *slope = -*slope);
            let (of_parameters, of_frequencies) = gradient.split_at_mut(n);
            let mut total = space.penalty(standardized, of_parameters) - value;
            let pairs = frequencies.chunks_exact(d).zip(of_frequencies.chunks_exact_mut(d));
            for (frequency, slopes) in pairs {
                total += options.spectrum.penalty(frequency, slopes);
            }
            check_outputs("log evidence", &[total], 1)?;
            check_outputs("gradient of the log evidence", gradient, point.len())?;
            Ok(total)
        };
        minimize(evaluate, start, limits)
    }

    fn tell(&self, best: &Minimum, report: &mut RffReport) {
        let standardized = &best.point[..self.names.len()];
        report.parameters = self.space.parameters(standardized);
        report.iterations += best.iterations;
        report.evaluations += best.evaluations;
        report.stop = Some(best.stop);
        let at_bound = self.space.at_bound(standardized).into_iter();
        report.at_bound = at_bound.map(|i| self.names[i].clone()).collect();
    }
}

/// Frequencies have settled where ten iterations together gain less, in nats.
const PROGRESS: f64 = 0.1;

/// Hyperparameters of the exact process on a random part of the rows.
fn small_process(x: MatRef<'_, f64>, y: &[f64], options: &RffOptions) -> Result<Vec<f64>, GpError> {
    let kernel = options.spectrum.kernel(&vec![1.0; x.ncols()], 1.0)?;
    check_learnable(&*kernel, x, y, &small_options(options))?;
    options.mean.check_constant()?;
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
