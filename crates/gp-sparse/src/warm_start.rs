//! Hyperparameters of an exact process on a few rows, from which all rows start.

use faer::{Mat, MatRef};
use gp_core::{Constraints, Gp, GpError, HyperPrior, Kernel, LearnOptions, Mean, SearchSpace};

use crate::placement::shuffled_rows;

/// An exact process on a random part of the rows.
pub(crate) struct WarmStart<'a> {
    pub(crate) rows: usize,
    pub(crate) seed: u64,
    pub(crate) mean: Mean,
    pub(crate) prior: HyperPrior,
    pub(crate) constraints: &'a Constraints,
}

impl WarmStart<'_> {
    /// Its hyperparameters; where those rows tell nothing, the usual start of the space.
    pub(crate) fn parameters(
        &self,
        kernel: &dyn Kernel,
        x: MatRef<'_, f64>,
        y: &[f64],
        row_noise: &[f64],
        space: &SearchSpace,
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
        match builder.constraints(self.constraints.clone()).fit(few.as_ref(), &few_y) {
            Ok(gp) => Ok(gp.hyperparameters().into_iter().map(|(_, value)| value).collect()),
            Err(_) => Ok(space.parameters(&space.start(0, self.seed))),
        }
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
