//! Learning pseudo-inputs and hyperparameters together.

use std::sync::Arc;

use faer::{Mat, MatRef};
use gp_core::bfgs::{Limits, Minimum, best_of, minimize};
use gp_core::checks::{check_inputs, check_outputs, check_positive, check_row_noise};
use gp_core::{
    Gp, GpError, HyperPrior, Kernel, LearnOptions, Mean, SearchSpace, StopReason, check_learnable,
};
use rayon::prelude::{IntoParallelIterator, ParallelIterator};

use crate::objective::Objective;
use crate::placement::shuffled_rows;
use crate::{Placement, PseudoInputs, SparseGp, SparseSettings};

/// How a sparse process is learnt.
#[derive(Clone, Debug, PartialEq)]
pub struct SparseOptions {
    /// The approximation, the mean and the jitter.
    pub settings: SparseSettings,
    /// The pseudo-inputs.
    pub pseudo_inputs: PseudoInputs,
    /// Known noise variance of each row beside the learnt common one, N, or none.
    pub row_noise: Vec<f64>,
    /// Rows of the exact process on a random part of the data from which hyperparameters start.
    pub warm_start_rows: usize,
    /// Number of starts, at least 1: the warm one, then a low-discrepancy set of hyperparameters.
    pub n_starts: usize,
    /// Seed of all that is drawn.
    pub seed: u64,
    /// Most quasi-Newton iterations of one start.
    pub max_iterations: usize,
    /// Largest component of the gradient at convergence, in nats per unit.
    pub gradient_tolerance: f64,
    /// Converged as well where ten iterations together gain less than this, in nats: the best
    /// places of pseudo-inputs form a flat valley.
    pub progress_tolerance: f64,
    /// What is known of the hyperparameters before the data.
    pub prior: HyperPrior,
}

impl Default for SparseOptions {
    fn default() -> Self {
        Self {
            settings: SparseSettings::default(),
            pseudo_inputs: PseudoInputs::Learnt { count: 50, placement: Placement::default() },
            row_noise: Vec::new(),
            warm_start_rows: 200,
            n_starts: 1,
            seed: 0,
            max_iterations: 1000,
            gradient_tolerance: 1e-3,
            progress_tolerance: 0.1,
            prior: HyperPrior::Flat,
        }
    }
}

/// What the optimiser did.
#[derive(Clone, Debug, PartialEq)]
pub struct SparseReport {
    /// Every start in order; an error where the objective does not exist at the start itself.
    pub starts: Vec<Result<SparseStart, GpError>>,
    /// The start that was taken: of those that converged, the one with the largest objective.
    pub best: SparseStart,
    /// Names of the hyperparameters that ended at a wall.
    pub at_bound: Vec<String>,
    /// Pseudo-inputs in use; fewer than asked for where more would repeat them.
    pub n_pseudo_inputs: usize,
}

/// One start of the optimiser; hyperparameters in the user's units, the noise variance last.
#[derive(Clone, Debug, PartialEq)]
pub struct SparseStart {
    /// Hyperparameters at the start.
    pub start: Vec<f64>,
    /// Hyperparameters at the end.
    pub parameters: Vec<f64>,
    /// The objective at the end, in nats.
    pub objective: f64,
    /// Largest component of the gradient there.
    pub gradient_norm: f64,
    /// Quasi-Newton iterations.
    pub iterations: usize,
    /// Evaluations of the objective with its gradient.
    pub evaluations: usize,
    /// Why it stopped.
    pub stop: StopReason,
}

impl SparseGp {
    /// Learns pseudo-inputs, kernel parameters and noise by maximising the objective.
    ///
    /// Hyperparameters start from an exact process on a few rows, pseudo-inputs from their
    /// placement; then all move together, with walls and scales as in [`gp_core::GpBuilder::fit`] and
    /// pseudo-inputs in units of their input's spread. An iteration costs O(N M²) and O((M D)²).
    /// The result does not depend on the number of threads.
    ///
    /// # Errors
    /// As `fit`; `TooFewRows` below two rows, `ConstantOutputs`, `NotConverged`.
    pub fn learn(
        kernel: impl Kernel + 'static,
        x: MatRef<'_, f64>,
        y: &[f64],
        options: &SparseOptions,
    ) -> Result<(Self, SparseReport), GpError> {
        Self::learn_dyn(&kernel, x, y, options)
    }

    pub(crate) fn learn_dyn(
        kernel: &dyn Kernel,
        x: MatRef<'_, f64>,
        y: &[f64],
        options: &SparseOptions,
    ) -> Result<(Self, SparseReport), GpError> {
        check_options(kernel, x, y, options)?;
        let space = SearchSpace::new(kernel, x, y, options.prior);
        let warm = WarmStart {
            rows: options.warm_start_rows,
            seed: options.seed,
            mean: options.settings.mean,
            prior: options.prior,
        };
        let warm = warm.parameters(kernel, x, y, &options.row_noise)?;
        let (placing, _) = split(kernel, &warm)?;
        let z = options.pseudo_inputs.place(&*placing, x, options.seed)?;
        let scales = (0..x.ncols()).map(|d| spread(x, d)).collect();
        let search = Search { kernel, x, y, space, warm, z, scales, options };
        let ends: Vec<_> = (0..options.n_starts).into_par_iter().map(|i| search.run(i)).collect();
        let (index, minimum) = best_of(&ends)?;
        let (parameters, z) = search.place_of(&minimum.point);
        let (learnt, noise_variance) = split(kernel, &parameters)?;
        let learnt = Arc::from(learnt);
        let data = (x, y, &*options.row_noise);
        let gp = Self::condition(learnt, data, &z, noise_variance, options.settings)?;
        let report = |(i, end): (usize, &Result<Minimum, GpError>)| match end {
            Ok(minimum) => Ok(search.report(i, minimum)),
            Err(error) => Err(error.clone()),
        };
        let starts = ends.iter().enumerate().map(report).collect();
        let best = search.report(index, minimum);
        let at_bound = search.at_bound(&minimum.point);
        let n_pseudo_inputs = gp.pseudo_inputs().nrows();
        Ok((gp, SparseReport { starts, best, at_bound, n_pseudo_inputs }))
    }
}

/// One optimisation problem, shared by all starts.
struct Search<'a> {
    kernel: &'a dyn Kernel,
    x: MatRef<'a, f64>,
    y: &'a [f64],
    space: SearchSpace,
    /// Hyperparameters to start from, the noise variance last.
    warm: Vec<f64>,
    /// Pseudo-inputs by rows.
    z: Vec<f64>,
    /// The unit of each coordinate of the pseudo-inputs.
    scales: Vec<f64>,
    options: &'a SparseOptions,
}

impl Search<'_> {
    fn run(&self, index: usize) -> Result<Minimum, GpError> {
        let options = self.options;
        let (n, m) = (self.warm.len(), self.z.len() / self.x.ncols());
        let mut objective =
            Objective::new(self.x, self.y, &options.row_noise, m, n - 1, options.settings);
        let limits = Limits {
            max_iterations: options.max_iterations,
            gradient_tolerance: options.gradient_tolerance,
            progress: Some((10, options.progress_tolerance)),
        };
        let evaluate = |point: &[f64], gradient: &mut [f64]| {
            let (parameters, z) = self.place_of(point);
            let (kernel, noise_variance) = split(self.kernel, &parameters)?;
            let value = objective.value(&*kernel, noise_variance, &z)?;
            objective.differentiate(&*kernel, noise_variance, gradient);
            gradient.iter_mut().for_each(|slope| *slope = -*slope);
            let (of_parameters, of_z) = gradient.split_at_mut(n);
            for (slope, scale) in of_z.iter_mut().zip(self.scales.iter().cycle()) {
                *slope *= scale;
            }
            let total = self.space.penalty(&point[..n], of_parameters) - value;
            check_outputs("objective", &[total], 1)?;
            check_outputs("gradient of the objective", gradient, point.len())?;
            Ok(total)
        };
        minimize(evaluate, &self.start(index), limits)
    }

    /// Standardised hyperparameters and, if they move, pseudo-inputs.
    fn start(&self, index: usize) -> Vec<f64> {
        let mut point = match index {
            0 => self.space.point(&self.warm),
            _ => self.space.start(index, self.options.seed),
        };
        if self.options.pseudo_inputs.are_learnt() {
            point.extend(self.z.iter().zip(self.scales.iter().cycle()).map(|(z, scale)| z / scale));
        }
        point
    }

    /// Hyperparameters and pseudo-inputs in the user's units.
    fn place_of(&self, point: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let (standardized, z) = point.split_at(self.warm.len());
        let z = if z.is_empty() {
            self.z.clone()
        } else {
            z.iter().zip(self.scales.iter().cycle()).map(|(z, scale)| z * scale).collect()
        };
        (self.space.parameters(standardized), z)
    }

    fn at_bound(&self, point: &[f64]) -> Vec<String> {
        let mut names: Vec<String> = self.kernel.parameters().into_iter().map(|p| p.name).collect();
        names.push("noise_variance".to_owned());
        let at_bound = self.space.at_bound(&point[..names.len()]);
        at_bound.into_iter().map(|i| names[i].clone()).collect()
    }

    fn report(&self, index: usize, minimum: &Minimum) -> SparseStart {
        let n = self.warm.len();
        let penalty = self.space.penalty(&minimum.point[..n], &mut vec![0.0; n]);
        SparseStart {
            start: self.space.parameters(&self.start(index)[..n]),
            parameters: self.space.parameters(&minimum.point[..n]),
            objective: penalty - minimum.value,
            gradient_norm: minimum.gradient_norm,
            iterations: minimum.iterations,
            evaluations: minimum.evaluations,
            stop: minimum.stop,
        }
    }
}

/// An exact process on a random part of the rows.
pub(crate) struct WarmStart {
    pub(crate) rows: usize,
    pub(crate) seed: u64,
    pub(crate) mean: Mean,
    pub(crate) prior: HyperPrior,
}

impl WarmStart {
    /// Its hyperparameters; where those rows tell nothing, the usual start.
    pub(crate) fn parameters(
        &self,
        kernel: &dyn Kernel,
        x: MatRef<'_, f64>,
        y: &[f64],
        row_noise: &[f64],
    ) -> Result<Vec<f64>, GpError> {
        let mut rows = shuffled_rows(y.len(), self.seed);
        rows.truncate(self.rows);
        let few = Mat::from_fn(rows.len(), x.ncols(), |i, d| x[(rows[i], d)]);
        let few_y: Vec<f64> = rows.iter().map(|&row| y[row]).collect();
        let learning = LearnOptions {
            n_starts: 2,
            seed: self.seed,
            gradient_tolerance: 0.1,
            mean: self.mean,
            prior: self.prior,
            ..LearnOptions::default()
        };
        let values: Vec<f64> = kernel.parameters().iter().map(|p| p.value).collect();
        let family = kernel.with_parameters(&values)?;
        let row_noise = rows_at(row_noise, &rows);
        let builder = Gp::builder(family).row_noise(&row_noise).options(learning);
        match builder.fit(few.as_ref(), &few_y) {
            Ok(gp) => Ok(gp.hyperparameters().into_iter().map(|(_, value)| value).collect()),
            Err(_) => {
                let space = SearchSpace::new(kernel, x, y, self.prior);
                Ok(space.parameters(&space.start(0, self.seed)))
            }
        }
    }
}

fn check_options(
    kernel: &dyn Kernel,
    x: MatRef<'_, f64>,
    y: &[f64],
    options: &SparseOptions,
) -> Result<(), GpError> {
    let learning = LearnOptions {
        n_starts: options.n_starts,
        gradient_tolerance: options.gradient_tolerance,
        mean: options.settings.mean,
        prior: options.prior,
        ..LearnOptions::default()
    };
    check_learnable(kernel, x, y, &learning)?;
    options.settings.check()?;
    check_row_noise(&options.row_noise, y.len())?;
    check_positive("progress_tolerance", options.progress_tolerance)?;
    match &options.pseudo_inputs {
        PseudoInputs::Given(z) => check_inputs("pseudo-inputs", z.as_ref(), x.ncols()),
        _ => Ok(()),
    }
}

/// What is known of some rows, if it is of all.
pub(crate) fn rows_at(values: &[f64], rows: &[usize]) -> Vec<f64> {
    rows.iter().filter_map(|&row| values.get(row).copied()).collect()
}

/// The kernel with the parameters, and the noise variance, which comes last.
pub(crate) fn split(
    kernel: &dyn Kernel,
    parameters: &[f64],
) -> Result<(Box<dyn Kernel>, f64), GpError> {
    let (noise_variance, values) = parameters.split_last().expect("the noise is always there");
    Ok((kernel.with_parameters(values)?, *noise_variance))
}

/// The standard deviation of an input; 1 for equal values.
pub(crate) fn spread(x: MatRef<'_, f64>, d: usize) -> f64 {
    let n = x.nrows() as f64;
    let mean = x.col(d).iter().sum::<f64>() / n;
    let variance = x.col(d).iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n;
    if variance > 0.0 { variance.sqrt() } else { 1.0 }
}
