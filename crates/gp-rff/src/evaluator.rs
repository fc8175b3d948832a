//! The evidence with its gradient, again and again.

use faer::MatRef;
use gp_core::GpError;
use gp_core::checks::{check_inputs, check_outputs, check_row_noise};

use crate::likelihood::Likelihood;
use crate::{RandomFeatures, RffGp};

/// The evidence and its gradient at the parameters of a process, on data of its own.
pub struct Evaluator {
    features: RandomFeatures,
    signal_variance: f64,
    noise_variance: f64,
    likelihood: Likelihood,
    gradient: Vec<f64>,
}

impl Evaluator {
    /// ln p(y) in nats; fills the gradient. O(N M²).
    ///
    /// # Errors
    /// `NotPositiveDefinite` if the noise is lost beside the signal.
    pub fn evaluate(&mut self) -> Result<f64, GpError> {
        let Self { features, signal_variance, noise_variance, likelihood, gradient } = self;
        likelihood.evaluate(features, *signal_variance, *noise_variance, gradient)
    }

    /// What `evaluate` found: by ln of the lengthscales, the signal variance and the noise variance.
    pub fn gradient(&self) -> &[f64] {
        &self.gradient
    }
}

impl RffGp {
    /// The evidence with its gradient again and again in the same memory, as while learning.
    ///
    /// # Errors
    /// `Empty`, `ShapeMismatch`, `NotFinite` for data that are not finite or do not fit together.
    pub fn evaluator(&self, x: MatRef<'_, f64>, y: &[f64]) -> Result<Evaluator, GpError> {
        self.evaluator_with_row_noise(x, y, &[])
    }

    /// As `evaluator`, with known noise variances of the rows, N, or none.
    ///
    /// # Errors
    /// As `evaluator`; `Negative` for a noise that is.
    pub fn evaluator_with_row_noise(
        &self,
        x: MatRef<'_, f64>,
        y: &[f64],
        row_noise: &[f64],
    ) -> Result<Evaluator, GpError> {
        check_inputs("inputs", x, self.features.n_inputs())?;
        check_outputs("outputs", y, x.nrows())?;
        check_row_noise(row_noise, y.len())?;
        Ok(Evaluator {
            features: self.features.clone(),
            signal_variance: self.signal_variance,
            noise_variance: self.noise_variance,
            likelihood: Likelihood::new(&self.features, (x, y, row_noise), self.mean)?,
            gradient: vec![0.0; self.features.n_inputs() + 2],
        })
    }
}
