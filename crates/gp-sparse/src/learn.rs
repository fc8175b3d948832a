//! Learning pseudo-inputs and hyperparameters together.

use std::sync::Arc;

use faer::MatRef;
use gp_core::bfgs::{Minimum, best_of};
use gp_core::{Constraints, GpError, Kernel, SearchSpace, hyperparameter_names};
use rayon::prelude::{IntoParallelIterator, ParallelIterator};

use crate::SparseGp;
use crate::options::SparseOptions;
use crate::placement::spread;
use crate::report::SparseReport;
use crate::search::Search;
use crate::warm_start::{WarmStart, split};

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
        let (gp, report) = Self::learn_asked(&kernel, (x, y), options, &Constraints::default())?;
        Ok((gp, report.as_ref().clone()))
    }

    /// What the optimiser did; nothing where the hyperparameters were given.
    pub fn report(&self) -> Option<&SparseReport> {
        self.report.as_deref()
    }

    pub(crate) fn learn_asked(
        kernel: &dyn Kernel,
        (x, y): (MatRef<'_, f64>, &[f64]),
        options: &SparseOptions,
        constraints: &Constraints,
    ) -> Result<(Self, Arc<SparseReport>), GpError> {
        options.check(kernel, x, y)?;
        let names = hyperparameter_names(kernel);
        let space = SearchSpace::new(kernel, x, y, options.prior);
        let space = space.constrained(&names, constraints)?;
        let warm = WarmStart {
            rows: options.warm_start_rows,
            seed: options.seed,
            mean: options.settings.mean,
            prior: options.prior,
            constraints,
        };
        let warm = warm.parameters(kernel, x, y, &options.row_noise, &space)?;
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
        let mut gp = Self::condition(learnt, data, &z, noise_variance, options.settings)?;
        let report = |(i, end): (usize, &Result<Minimum, GpError>)| match end {
            Ok(minimum) => Ok(search.report(i, minimum)),
            Err(error) => Err(error.clone()),
        };
        let starts = ends.iter().enumerate().map(report).collect();
        let best = search.report(index, minimum);
        let at_bound = search.at_bound(&minimum.point, &names);
        let n_pseudo_inputs = gp.pseudo_inputs().nrows();
        let report = SparseReport { names, starts, best, at_bound, n_pseudo_inputs };
        let report = Arc::new(report);
        gp.report = Some(report.clone());
        Ok((gp, report))
    }
}
