//! Learning a process whose noise has heavy tails.

use std::sync::Arc;

use faer::MatRef;
use rayon::prelude::{IntoParallelIterator, ParallelIterator};

use crate::bfgs::{Limits, Minimum, best_of, minimize};
use crate::checks::check_outputs;
use crate::student_t_bound::{StudentTBound, Tails};
use crate::{GpError, Kernel, LearnOptions, SearchSpace, StopReason, StudentTGp, check_learnable};

/// What the optimiser did.
#[derive(Clone, Debug, PartialEq)]
pub struct StudentTReport {
    /// Parameters of the kernel, then σ² and ν − 2, in the user's units.
    pub parameters: Vec<f64>,
    /// The bound of ln p(y | X), in nats.
    pub bound: f64,
    /// Largest component of the gradient there, in nats per log-parameter.
    pub gradient_norm: f64,
    /// Quasi-Newton iterations of the start that was taken.
    pub iterations: usize,
    /// Evaluations of the bound with its gradient.
    pub evaluations: usize,
    /// Why it stopped.
    pub stop: StopReason,
    /// Names of the parameters that ended at a wall: the degrees of freedom where the noise is
    /// Gaussian.
    pub at_bound: Vec<String>,
}

impl StudentTGp {
    /// Learns the kernel's parameters, and scale and degrees of freedom of the noise, by maximising
    /// the bound; O(N³) a step.
    ///
    /// Starts, walls and scales are as in [`GpBuilder::fit`](crate::GpBuilder::fit); ν starts at 4, between
    /// walls at 2.002 and 2002.
    ///
    /// # Errors
    /// As [`GpBuilder::fit`](crate::GpBuilder::fit).
    pub fn learn(
        kernel: impl Kernel + 'static,
        x: MatRef<'_, f64>,
        y: &[f64],
        options: &LearnOptions,
    ) -> Result<(Self, StudentTReport), GpError> {
        check_learnable(&kernel, x, y, options)?;
        let space = SearchSpace::new(&kernel, x, y, options.prior).with_shape(2.0);
        let search = Search { kernel: &kernel, x, y, space: &space, options };
        let ends: Vec<_> = (0..options.n_starts).into_par_iter().map(|i| search.run(i)).collect();
        let (_, best) = best_of(&ends)?;
        let (learnt, tails) = search.place_of(&best.point)?;
        let gp = Self::condition(Arc::from(learnt), x, y, tails, options.mean)?;
        let mut names: Vec<String> = kernel.parameters().into_iter().map(|p| p.name).collect();
        names.extend(["scale_variance", "degrees_of_freedom"].map(String::from));
        let at_bound = space.at_bound(&best.point).into_iter().map(|i| names[i].clone()).collect();
        let report = StudentTReport {
            parameters: space.parameters(&best.point),
            bound: gp.bound(),
            gradient_norm: best.gradient_norm,
            iterations: best.iterations,
            evaluations: best.evaluations,
            stop: best.stop,
            at_bound,
        };
        Ok((gp, report))
    }
}

/// One optimisation problem, shared by all starts; a point holds the standardised parameters of the
/// kernel, ln σ² likewise, and ln (ν − 2).
struct Search<'a> {
    kernel: &'a dyn Kernel,
    x: MatRef<'a, f64>,
    y: &'a [f64],
    space: &'a SearchSpace,
    options: &'a LearnOptions,
}

impl Search<'_> {
    fn run(&self, index: usize) -> Result<Minimum, GpError> {
        let mut bound = StudentTBound::new(self.x, self.y, self.options.mean);
        let limits = Limits {
            max_iterations: self.options.max_iterations,
            gradient_tolerance: self.options.gradient_tolerance,
            progress: None,
        };
        let objective = |point: &[f64], gradient: &mut [f64]| {
            let (kernel, tails) = self.place_of(point)?;
            let value = bound.evaluate(&*kernel, tails, gradient)?;
            gradient.iter_mut().for_each(|slope| *slope = -*slope);
            gradient[point.len() - 1] *= tails.degrees - 2.0;
            let total = self.space.penalty(point, gradient) - value;
            check_outputs("bound", &[total], 1)?;
            check_outputs("gradient of the bound", gradient, point.len())?;
            Ok(total)
        };
        minimize(objective, &self.space.start(index, self.options.seed), limits)
    }

    fn place_of(&self, point: &[f64]) -> Result<(Box<dyn Kernel>, Tails), GpError> {
        let parameters = self.space.parameters(point);
        let (of_kernel, of_noise) = parameters.split_at(point.len() - 2);
        let tails = Tails { scale_variance: of_noise[0], degrees: 2.0 + of_noise[1] };
        Ok((self.kernel.with_parameters(of_kernel)?, tails))
    }
}
