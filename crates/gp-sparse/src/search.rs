//! The maximum of the objective over pseudo-inputs and hyperparameters.

use faer::{Mat, MatRef};
use gp_core::bfgs::{Limits, Minimum, minimize};
use gp_core::checks::check_outputs;
use gp_core::{GpError, Kernel, SearchSpace, StopReason};

use crate::batches::{Batches, Optimizer};
use crate::objective::{Belief, Objective};
use crate::options::SparseOptions;
use crate::report::SparseStart;
use crate::warm_start::{rows_at, split};

/// One optimisation problem, shared by all starts.
pub(crate) struct Search<'a> {
    pub(crate) kernel: &'a dyn Kernel,
    pub(crate) x: MatRef<'a, f64>,
    pub(crate) y: &'a [f64],
    pub(crate) space: SearchSpace,
    /// Hyperparameters to start from, the noise variance last.
    pub(crate) warm: Vec<f64>,
    /// Pseudo-inputs by rows.
    pub(crate) z: Vec<f64>,
    /// The unit of each coordinate of the pseudo-inputs.
    pub(crate) scales: Vec<f64>,
    pub(crate) options: &'a SparseOptions,
}

impl Search<'_> {
    pub(crate) fn run(&self, index: usize) -> Result<Minimum, GpError> {
        match self.options.optimizer {
            Optimizer::QuasiNewton => self.run_on_all_rows(index),
            Optimizer::Stochastic(batches) => self.run_on_batches(index, batches),
        }
    }

    fn run_on_batches(&self, index: usize, batches: Batches) -> Result<Minimum, GpError> {
        let (options, n_rows) = (self.options, self.y.len());
        let (n, n_moving) = (self.warm.len(), self.space.n_coordinates());
        let m = self.z.len() / self.x.ncols();
        let mut objective = Objective::empty((self.x, self.y), m, options.settings);
        let start = self.start(index);
        let mut slopes = vec![0.0; n + start.len() - n_moving];
        let mut is_first = true;
        let evaluate = |rows: &[usize], point: &[f64], gradient: &mut [f64]| {
            let (parameters, z) = self.place_of(point);
            let (kernel, noise_variance) = split(self.kernel, &parameters)?;
            let x = Mat::from_fn(rows.len(), self.x.ncols(), |i, d| self.x[(rows[i], d)]);
            let y: Vec<f64> = rows.iter().map(|&row| self.y[row]).collect();
            objective.take((x.as_ref(), &y, &rows_at(&options.row_noise, rows)), n - 1);
            objective.place(&*kernel, &z)?;
            objective.sum(&*kernel, noise_variance);
            let (scale, share) = (n_rows as f64 / rows.len() as f64, batches.natural_step);
            // A belief from these rows as well would take them for better known than others are.
            let knows_all = rows.len() == n_rows && share == 1.0;
            if is_first || knows_all {
                objective.move_to_parts(scale, 1.0);
            }
            objective.solve()?;
            let belief = Belief::OfOtherRows;
            objective.differentiate_given(&*kernel, noise_variance, belief, &mut slopes);
            if !is_first && !knows_all {
                objective.move_to_parts(scale, share);
            }
            is_first = false;
            slopes.iter_mut().for_each(|slope| *slope *= -scale);
            self.by_point(point, &slopes, gradient);
            self.space.penalty(&point[..n_moving], &mut gradient[..n_moving]);
            check_outputs("gradient of the objective", gradient, point.len())
        };
        let seed = options.seed.wrapping_add(index as u64);
        let (point, gradient_norm) = batches.descend(n_rows, seed, start, evaluate)?;
        let (parameters, z) = self.place_of(&point);
        let (kernel, noise_variance) = split(self.kernel, &parameters)?;
        let data = (self.x, self.y, &*options.row_noise);
        let value = objective.value_of(data, &*kernel, noise_variance, &z)?;
        let penalty = self.space.penalty(&point[..n_moving], &mut vec![0.0; n_moving]);
        let (iterations, evaluations) = (batches.steps, batches.steps);
        let (value, stop) = (penalty - value, StopReason::StepsTaken);
        check_outputs("objective", &[value], 1)?;
        // Between its steps the whole objective is not known.
        let history = Vec::new();
        Ok(Minimum { point, value, gradient_norm, iterations, evaluations, stop, history })
    }

    /// From slopes by hyperparameters and pseudo-inputs those by the coordinates of a point.
    fn by_point(&self, point: &[f64], slopes: &[f64], gradient: &mut [f64]) {
        let n_moving = self.space.n_coordinates();
        let (by_parameters, by_z) = slopes.split_at(self.warm.len());
        let (of_space, of_z) = gradient.split_at_mut(n_moving);
        let scaled = by_z.iter().zip(self.scales.iter().cycle());
        of_z.iter_mut().zip(scaled).for_each(|(of_z, (slope, scale))| *of_z = slope * scale);
        self.space.by_coordinates(&point[..n_moving], by_parameters, of_space);
    }

    fn run_on_all_rows(&self, index: usize) -> Result<Minimum, GpError> {
        let options = self.options;
        let (n, m) = (self.warm.len(), self.z.len() / self.x.ncols());
        let n_moving = self.space.n_coordinates();
        let mut objective =
            Objective::new(self.x, self.y, &options.row_noise, m, n - 1, options.settings);
        let limits = Limits {
            max_iterations: options.max_iterations,
            gradient_tolerance: options.gradient_tolerance,
            progress: Some((10, options.progress_tolerance)),
        };
        let start = self.start(index);
        let mut slopes = vec![0.0; n + start.len() - n_moving];
        let evaluate = |point: &[f64], gradient: &mut [f64]| {
            let (parameters, z) = self.place_of(point);
            let (kernel, noise_variance) = split(self.kernel, &parameters)?;
            let value = objective.value(&*kernel, noise_variance, &z)?;
            objective.differentiate(&*kernel, noise_variance, &mut slopes);
            slopes.iter_mut().for_each(|slope| *slope = -*slope);
            self.by_point(point, &slopes, gradient);
            let of_space = &mut gradient[..n_moving];
            let total = self.space.penalty(&point[..n_moving], of_space) - value;
            check_outputs("objective", &[total], 1)?;
            check_outputs("gradient of the objective", gradient, point.len())?;
            Ok(total)
        };
        minimize(evaluate, &start, limits)
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
    pub(crate) fn place_of(&self, point: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let (standardized, z) = point.split_at(self.space.n_coordinates());
        let z = if z.is_empty() {
            self.z.clone()
        } else {
            z.iter().zip(self.scales.iter().cycle()).map(|(z, scale)| z * scale).collect()
        };
        (self.space.parameters(standardized), z)
    }

    pub(crate) fn at_bound(&self, point: &[f64], names: &[String]) -> Vec<String> {
        let at_bound = self.space.at_bound(&point[..self.space.n_coordinates()]);
        at_bound.into_iter().map(|i| names[i].clone()).collect()
    }

    pub(crate) fn report(&self, index: usize, minimum: &Minimum) -> SparseStart {
        let n = self.space.n_coordinates();
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
