//! Learning lengthscales, signal and noise.

use std::sync::Arc;

use faer::{Mat, MatRef};
use gp_core::bfgs::{Limits, Minimum, best_of, minimize};
use gp_core::checks::{check_inputs, check_outputs, check_row_noise};
use gp_core::{
    Constraints, Gp, GpError, LearnOptions, SearchSpace, check_learnable, hyperparameter_names,
};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::{IntoParallelRefIterator, ParallelIterator};

use crate::likelihood::Likelihood;
use crate::options::{Hyperparameters, RffOptions};
use crate::report::RffReport;
use crate::{RandomFeatures, RffGp};

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
        let asked = Asked { options, constraints: &Constraints::default(), features: None };
        let (gp, report) = asked.learn(x, y)?;
        Ok((gp, report.as_ref().clone()))
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
        let features = Some(&features);
        let asked = Asked { options, constraints: &Constraints::default(), features };
        let (gp, report) = asked.learn(x, y)?;
        Ok((gp, report.as_ref().clone()))
    }

    /// What the optimiser did; nothing where the hyperparameters were given.
    pub fn report(&self) -> Option<&RffReport> {
        self.report.as_deref()
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

/// Everything but the data.
pub(crate) struct Asked<'a> {
    pub(crate) options: &'a RffOptions,
    pub(crate) constraints: &'a Constraints,
    /// Drawn if they are not given.
    pub(crate) features: Option<&'a RandomFeatures>,
}

impl Asked<'_> {
    pub(crate) fn learn(
        &self,
        x: MatRef<'_, f64>,
        y: &[f64],
    ) -> Result<(RffGp, Arc<RffReport>), GpError> {
        let (d, options) = (x.ncols(), self.options);
        if let Some(features) = self.features {
            check_inputs("inputs", x, features.n_inputs())?;
        }
        let kernel = options.spectrum.kernel(&vec![1.0; d], 1.0)?;
        check_learnable(&*kernel, x, y, &small_options(options))?;
        check_row_noise(&options.row_noise, y.len())?;
        let names = hyperparameter_names(&*kernel);
        let space = SearchSpace::new(&*kernel, x, y, options.prior);
        let space = space.constrained(&names, self.constraints)?;
        let small_gp = self.small_process(x, y)?;
        let mut features = match self.features {
            Some(given) => given.with_lengthscales(&small_gp[..d])?,
            None => RandomFeatures::new(options.spectrum, &small_gp[..d], options.features)?,
        };
        let mut report = RffReport {
            names,
            parameters: small_gp.clone(),
            small_gp,
            iterations: 0,
            evaluations: 0,
            stop: None,
            at_bound: Vec::new(),
        };
        if options.hyperparameters != Hyperparameters::SmallGp {
            let own = Own { features: &features, x, y, options, space };
            features.frequencies = own.maximize(&mut report)?;
        }
        let features = features.with_lengthscales(&report.parameters[..d])?;
        let (signal, noise) = (report.parameters[d], report.parameters[d + 1]);
        let data = (x, y, &*options.row_noise);
        let mut gp = RffGp::fit_with(features, data, signal, noise, options.mean)?;
        let report = Arc::new(report);
        gp.report = Some(report.clone());
        Ok((gp, report))
    }

    /// Hyperparameters of the exact process on a random part of the rows.
    fn small_process(&self, x: MatRef<'_, f64>, y: &[f64]) -> Result<Vec<f64>, GpError> {
        let options = self.options;
        let mut rows: Vec<usize> = (0..y.len()).collect();
        rows.shuffle(&mut ChaCha8Rng::seed_from_u64(options.seed));
        rows.truncate(options.small_gp_rows);
        let few = Mat::from_fn(rows.len(), x.ncols(), |i, d| x[(rows[i], d)]);
        let few_y: Vec<f64> = rows.iter().map(|&row| y[row]).collect();
        let own = |&row: &usize| options.row_noise.get(row).copied();
        let row_noise: Vec<f64> = rows.iter().filter_map(own).collect();
        let family = options.spectrum.kernel(&vec![1.0; x.ncols()], 1.0)?;
        let builder = Gp::builder(family).options(small_options(options)).row_noise(&row_noise);
        let builder = builder.constraints(self.constraints.clone());
        let gp = builder.fit(few.as_ref(), &few_y)?;
        Ok(gp.hyperparameters().into_iter().map(|(_, value)| value).collect())
    }
}

/// The maximum of the features' own likelihood, from several starts.
struct Own<'a> {
    features: &'a RandomFeatures,
    x: MatRef<'a, f64>,
    y: &'a [f64],
    options: &'a RffOptions,
    space: SearchSpace,
}

impl Own<'_> {
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
            return Ok(best.point[self.space.n_coordinates()..].to_vec());
        }
        Ok(self.features.frequencies.clone())
    }

    /// From standardised hyperparameters, and from frequencies behind them if they are to move.
    fn minimize(&self, start: &[f64]) -> Result<Minimum, GpError> {
        let Self { features, x, y, options, space } = self;
        let (d, n) = (x.ncols(), space.n_coordinates());
        let progress = (start.len() > n).then_some((10, PROGRESS));
        let limits = Limits {
            max_iterations: options.max_iterations.max(if start.len() > n { 1000 } else { 0 }),
            gradient_tolerance: options.gradient_tolerance,
            progress,
        };
        let mut likelihood = Likelihood::new(features, (*x, y, &options.row_noise), options.mean)?;
        let mut slopes = vec![0.0; d + 2 + start.len() - n];
        let evaluate = |point: &[f64], gradient: &mut [f64]| {
            let (standardized, frequencies) = point.split_at(n);
            let parameters = space.parameters(standardized);
            let mut moved = features.with_lengthscales(&parameters[..d])?;
            if !frequencies.is_empty() {
                moved.frequencies = frequencies.to_vec();
            }
            let (signal, noise) = (parameters[d], parameters[d + 1]);
            let value = likelihood.evaluate(&moved, signal, noise, &mut slopes)?;
            slopes.iter_mut().for_each(|slope| *slope = -*slope);
            let (by_parameters, by_frequencies) = slopes.split_at(d + 2);
            let (of_space, of_frequencies) = gradient.split_at_mut(n);
            space.by_coordinates(standardized, by_parameters, of_space);
            of_frequencies.copy_from_slice(by_frequencies);
            let mut total = space.penalty(standardized, of_space) - value;
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
        let standardized = &best.point[..self.space.n_coordinates()];
        report.parameters = self.space.parameters(standardized);
        report.iterations += best.iterations;
        report.evaluations += best.evaluations;
        report.stop = Some(best.stop);
        let at_bound = self.space.at_bound(standardized).into_iter();
        report.at_bound = at_bound.map(|i| report.names[i].clone()).collect();
    }
}

/// Frequencies have settled where ten iterations together gain less, in nats.
const PROGRESS: f64 = 0.1;

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
