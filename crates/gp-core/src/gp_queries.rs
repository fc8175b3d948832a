//! What an exact process is asked most: predictions, hyperparameters, and how far to trust them.

use faer::MatRef;

use crate::cholesky::solve_with;
use crate::constraints::hyperparameter_names;
use crate::vector::{add_multiple, dot};
use crate::{Gp, GpError, Inputs, Posterior};

impl Gp {
    /// The mean and variance of f at each input, as [`Posterior::predict`] of inputs in any form.
    ///
    /// # Errors
    /// As there.
    pub fn predict<'a>(
        &self,
        x_star: impl Into<Inputs<'a>>,
    ) -> Result<(Vec<f64>, Vec<f64>), GpError> {
        Posterior::predict(self, x_star.into().matrix())
    }

    /// The hyperparameters by name, the noise variance last.
    pub fn hyperparameters(&self) -> Vec<(String, f64)> {
        let values = self.kernel().parameters().into_iter().map(|p| p.value);
        hyperparameter_names(self.kernel())
            .into_iter()
            .zip(values.chain([self.noise_variance()]))
            .collect()
    }

    /// The condition number of the covariance of the observations, from below: largest over smallest
    /// eigenvalue, each by a few power iterations; O(N²).
    ///
    /// About 16 less its decimal logarithm digits of the weights are right.
    pub fn condition_number(&self) -> f64 {
        let factor = self.cholesky.factor();
        let n = factor.nrows();
        let multiply = |v: &mut Vec<f64>| {
            let across: Vec<f64> = (0..n).map(|j| dot(lower(factor, j), &v[j..])).collect();
            v.fill(0.0);
            (0..n).for_each(|j| add_multiple(&mut v[j..], across[j], lower(factor, j)));
        };
        largest(n, multiply) * largest(n, |v| solve_with(factor, v))
    }
}

/// Column `j` of a lower triangle.
fn lower<'a>(factor: MatRef<'a, f64>, j: usize) -> &'a [f64] {
    &factor.col(j).try_as_col_major().expect("owned matrices are column-major").as_slice()[j..]
}

/// The largest eigenvalue of a symmetric map, from below.
fn largest(n: usize, map: impl Fn(&mut Vec<f64>)) -> f64 {
    // Turns of the golden angle: along no direction of the data.
    let mut v: Vec<f64> = (0..n).map(|i| 1.0 + (2.4 * i as f64).sin()).collect();
    let mut growth = 0.0;
    for _ in 0..ITERATIONS {
        let length = dot(&v, &v).sqrt();
        v.iter_mut().for_each(|value| *value /= length);
        map(&mut v);
        growth = dot(&v, &v).sqrt();
    }
    growth
}

/// Power iterations: enough for the order of magnitude.
const ITERATIONS: usize = 30;
