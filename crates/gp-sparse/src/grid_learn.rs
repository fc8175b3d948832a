//! Learning the parameters of a process on a grid.

use std::sync::Arc;

use faer::MatRef;
use gp_core::bfgs::{Limits, Minimum, minimize};
use gp_core::checks::{check_outputs, check_positive};
use gp_core::{
    Constraints, GpError, Kernel, LearnOptions, SearchSpace, check_learnable, hyperparameter_names,
};

use crate::grid::Grid;
use crate::grid_objective::GridObjective;
use crate::grid_options::{lengthscales, summed};
use crate::grid_report::GridReport;
use crate::grid_sums::GridSums;
use crate::warm_start::{WarmStart, split};
use crate::{GridGp, GridOptions};

impl GridGp {
    /// Learns kernel parameters and noise by maximising the marginal likelihood of all rows.
    ///
    /// Parameters start from an exact process on a few rows, whose lengthscales tell how near the nodes
    /// have to be. The result does not depend on the number of threads.
    ///
    /// # Errors
    /// As `fit`; `TooFewRows` below two rows, `ConstantOutputs`, `NotConverged`.
    pub fn learn(
        kernel: impl Kernel + 'static,
        x: MatRef<'_, f64>,
        y: &[f64],
        options: &GridOptions,
    ) -> Result<(Self, GridReport), GpError> {
        let (gp, report) = Self::learn_asked(&kernel, (x, y), options, &Constraints::default())?;
        Ok((gp, report.as_ref().clone()))
    }

    /// What the optimiser did; nothing where the hyperparameters were given.
    pub fn report(&self) -> Option<&GridReport> {
        self.report.as_deref()
    }

    pub(crate) fn learn_asked(
        kernel: &dyn Kernel,
        (x, y): (MatRef<'_, f64>, &[f64]),
        options: &GridOptions,
        constraints: &Constraints,
    ) -> Result<(Self, Arc<GridReport>), GpError> {
        let learning =
            LearnOptions { mean: options.mean, prior: options.prior, ..LearnOptions::default() };
        check_learnable(kernel, x, y, &learning)?;
        check_positive("gradient_tolerance", options.gradient_tolerance)?;
        let warm = WarmStart {
            rows: options.warm_start_rows,
            seed: options.seed,
            mean: options.mean,
            prior: options.prior,
            constraints,
        };
        let names = hyperparameter_names(kernel);
        let space = SearchSpace::new(kernel, x, y, options.prior);
        let space = space.constrained(&names, constraints)?;
        let start = warm.parameters(kernel, x, y, &[], &space)?;
        let (warm, _) = split(kernel, &start)?;
        let (grid, sums) = summed(&*warm, x, y, options)?;
        let minimum = maximize(kernel, &space, (&grid, &sums), &start, options)?;
        let parameters = space.parameters(&minimum.point);
        let (learnt, noise_variance) = split(kernel, &parameters)?;
        let learnt: Arc<dyn Kernel> = Arc::from(learnt);
        let widest_spacing = widest(&grid.spacing, &lengthscales(&*learnt, x));
        let n_nodes = grid.n_nodes();
        let mut gp =
            Self::condition(learnt, noise_variance, (grid, sums), options.mean, options.jitter)?;
        let at_bound = space.at_bound(&minimum.point).into_iter().map(|i| names[i].clone());
        let at_bound = at_bound.collect();
        let report = GridReport {
            names,
            start,
            parameters,
            log_marginal_likelihood: gp.log_marginal_likelihood(),
            gradient_norm: minimum.gradient_norm,
            iterations: minimum.iterations,
            evaluations: minimum.evaluations,
            stop: minimum.stop,
            at_bound,
            n_nodes,
            widest_spacing,
        };
        let report = Arc::new(report);
        gp.report = Some(report.clone());
        Ok((gp, report))
    }
}

fn maximize(
    kernel: &dyn Kernel,
    space: &SearchSpace,
    (grid, sums): (&Grid, &GridSums),
    start: &[f64],
    options: &GridOptions,
) -> Result<Minimum, GpError> {
    let mut objective = GridObjective::new(sums, grid.positions(), options.mean, options.jitter);
    let mut by_parameters = vec![0.0; start.len()];
    let limits = Limits {
        max_iterations: options.max_iterations,
        gradient_tolerance: options.gradient_tolerance,
        progress: None,
    };
    let evaluate = |point: &[f64], gradient: &mut [f64]| {
        let (moved, noise_variance) = split(kernel, &space.parameters(point))?;
        let value = objective.value(&*moved, noise_variance)?;
        objective.differentiate(&*moved, noise_variance, &mut by_parameters);
        by_parameters.iter_mut().for_each(|slope| *slope = -*slope);
        space.by_coordinates(point, &by_parameters, gradient);
        let total = space.penalty(point, gradient) - value;
        check_outputs("log marginal likelihood", &[total], 1)?;
        check_outputs("gradient of the log marginal likelihood", gradient, point.len())?;
        Ok(total)
    };
    let minimum = minimize(evaluate, &space.point(start), limits)?;
    if minimum.stop.converged() {
        return Ok(minimum);
    }
    let Minimum { iterations, gradient_norm, .. } = minimum;
    Err(GpError::NotConverged { n_starts: 1, iterations, gradient_norm })
}

fn widest(spacing: &[f64], lengthscales: &[f64]) -> f64 {
    spacing.iter().zip(lengthscales).map(|(h, l)| h / l).fold(0.0, f64::max)
}
