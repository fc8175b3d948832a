//! What an exact process is asked most: predictions, hyperparameters, and how far to trust them.

use crate::constraints::hyperparameter_names;
use crate::root::Root;
use crate::vector::dot;
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
        let n = self.y.len();
        largest(n, |v| self.factor.multiply(v)) * largest(n, |v| self.factor.solve_whole(v))
    }
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
