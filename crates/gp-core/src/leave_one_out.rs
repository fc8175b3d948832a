//! Leave-one-out predictions of an exact Gaussian process in closed form.

use std::f64::consts::PI;

/// The prediction of every training observation from all the others.
///
/// mean_i = y_i − α_i / Pᵢᵢ and variance_i = 1 / Pᵢᵢ, with α = K⁻¹(y − m), and P = K⁻¹ of a known mean,
/// K⁻¹ − K⁻¹H(HᵀK⁻¹H)⁻¹HᵀK⁻¹ of a learnt one, which is learnt from the others too. Hyperparameters stay
/// as they were with all rows.
///
/// # Source
/// Rasmussen & Williams, Gaussian Processes for Machine Learning (2006), ch. 5; Dubrule, Cross
/// validation of kriging in a unique neighborhood (1983).
#[derive(Clone, Debug, PartialEq)]
pub struct LeaveOneOut {
    /// Predicted mean of each output.
    pub mean: Vec<f64>,
    /// Predicted variance of each observation, noise included.
    pub variance: Vec<f64>,
    /// Log density of each output under its prediction, in nats.
    pub log_density: Vec<f64>,
}

impl LeaveOneOut {
    pub(crate) fn new(y: &[f64], weights: &[f64], inverse_diagonal: &[f64]) -> Self {
        let variance: Vec<f64> = inverse_diagonal.iter().map(|inverse| inverse.recip()).collect();
        let error = || weights.iter().zip(&variance).map(|(weight, variance)| weight * variance);
        let mean = y.iter().zip(error()).map(|(y, error)| y - error).collect();
        let density = |(error, variance): (f64, &f64)| {
            -0.5 * (error * error / variance + (2.0 * PI * variance).ln())
        };
        let log_density = error().zip(&variance).map(density).collect();
        Self { mean, variance, log_density }
    }

    /// Σᵢ ln p(yᵢ | all others), in nats.
    pub fn total_log_density(&self) -> f64 {
        self.log_density.iter().sum()
    }
}
