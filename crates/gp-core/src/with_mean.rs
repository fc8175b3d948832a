//! A posterior about a mean function of the user's, such as a physical model.

use std::fmt;

use faer::MatRef;
use serde::{Deserialize, Serialize};

use crate::checks::{check_inputs, check_outputs};
use crate::kernel::copy_row;
use crate::{GpError, JointGaussian, Posterior};

/// A function of D inputs that a process is about: any closure, or a type of your own.
pub trait MeanFunction: Send + Sync {
    /// m(x), in the unit of the output.
    fn value(&self, x: &[f64]) -> f64;
}

impl<F: Fn(&[f64]) -> f64 + Send + Sync> MeanFunction for F {
    fn value(&self, x: &[f64]) -> f64 {
        self(x)
    }
}

/// f(x) = m(x) + g(x), where m is a known function and the posterior is about g.
///
/// With a process for g this is the process with the mean m: where data are far, predictions return
/// to m and variances to the prior's.
///
/// It is saved and read with its function where that is a type of plain data; of a closure save the
/// `residual`, and put both together again by [`WithMean::about`].
#[derive(Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WithMean<M, P> {
    function: M,
    residual: P,
}

impl<M: MeanFunction, P: Posterior> WithMean<M, P> {
    /// Learns what the function leaves over.
    ///
    /// - `x`: inputs, N×D; `y`: outputs, N.
    /// - `fit`: makes the posterior of the residuals y − m(x), which it is given.
    ///
    /// # Errors
    /// `Empty`, `ShapeMismatch`, `NotFinite` for data or values of m; else those of `fit`.
    pub fn fit(
        function: M,
        x: MatRef<'_, f64>,
        y: &[f64],
        fit: impl FnOnce(&[f64]) -> Result<P, GpError>,
    ) -> Result<Self, GpError> {
        check_inputs("inputs", x, x.ncols())?;
        check_outputs("outputs", y, x.nrows())?;
        let values = values(&function, x)?;
        let residuals: Vec<f64> = y.iter().zip(&values).map(|(y, value)| y - value).collect();
        Ok(Self { residual: fit(&residuals)?, function })
    }

    /// A known function, and the posterior of what it leaves over.
    pub fn about(function: M, residual: P) -> Self {
        Self { function, residual }
    }

    /// The mean function m.
    pub fn function(&self) -> &M {
        &self.function
    }

    /// The posterior of what the function leaves over.
    pub fn residual(&self) -> &P {
        &self.residual
    }

    fn add_to(&self, x_star: MatRef<'_, f64>, mean: &mut [f64]) -> Result<(), GpError> {
        let values = values(&self.function, x_star)?;
        mean.iter_mut().zip(&values).for_each(|(mean, value)| *mean += value);
        Ok(())
    }
}

/// m of every row.
fn values(function: &impl MeanFunction, x: MatRef<'_, f64>) -> Result<Vec<f64>, GpError> {
    let mut row = vec![0.0; x.ncols()];
    let value = |i: usize| {
        copy_row(x, i, &mut row);
        function.value(&row)
    };
    let values: Vec<f64> = (0..x.nrows()).map(value).collect();
    check_outputs("mean function", &values, x.nrows())?;
    Ok(values)
}

impl<M: MeanFunction, P: Posterior> Posterior for WithMean<M, P> {
    fn n_inputs(&self) -> usize {
        self.residual.n_inputs()
    }

    fn predict_mean(&self, x_star: MatRef<'_, f64>) -> Result<Vec<f64>, GpError> {
        let mut mean = self.residual.predict_mean(x_star)?;
        self.add_to(x_star, &mut mean)?;
        Ok(mean)
    }

    fn predict(&self, x_star: MatRef<'_, f64>) -> Result<(Vec<f64>, Vec<f64>), GpError> {
        let (mut mean, variance) = self.residual.predict(x_star)?;
        self.add_to(x_star, &mut mean)?;
        Ok((mean, variance))
    }

    fn predict_joint(&self, x_star: MatRef<'_, f64>) -> Result<JointGaussian, GpError> {
        let joint = self.residual.predict_joint(x_star)?;
        let mut mean = joint.mean().to_vec();
        self.add_to(x_star, &mut mean)?;
        JointGaussian::new(mean, joint.covariance().to_owned())
    }

    fn predict_noise(&self, x_star: MatRef<'_, f64>) -> Result<Vec<f64>, GpError> {
        self.residual.predict_noise(x_star)
    }
}

impl<M, P: fmt::Debug> fmt::Debug for WithMean<M, P> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.debug_struct("WithMean").field("residual", &self.residual).finish_non_exhaustive()
    }
}
