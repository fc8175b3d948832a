//! A posterior about transformed outputs, seen in the outputs' own unit.

use std::f64::consts::PI;

use faer::{Mat, MatRef};
use serde::{Deserialize, Serialize};

use crate::checks::check_outputs;
use crate::{GpError, Inputs, Posterior, Transform, quantile};

/// Observations y with g(y) = f(x) + noise, g a [`Transform`] and the posterior about f: positive
/// outputs, and errors that grow with them.
///
/// Beliefs about y are not Gaussian, so this is no `Posterior` itself: ask it for quantiles, moments
/// and densities of observations, in the unit of the output.
/// ```
/// use gp_core::{Gp, SquaredExponential, Transform, Warped};
///
/// let x: Vec<f64> = (0..40).map(|i| 0.2 * f64::from(i)).collect();
/// let y: Vec<f64> = x.iter().map(|x| (x.sin() + 0.05 * (31.0 * x).cos()).exp()).collect();
/// let process = Gp::builder(SquaredExponential::isotropic(1.0));
/// let warped = Warped::fit(Transform::Log, &y, |z| process.fit(&x, z))?;
/// let interval = warped.quantiles(&[2.5, 3.1], &[0.05, 0.95])?;
/// assert!(interval[(0, 0)] > 0.0 && interval[(0, 1)] > interval[(0, 0)]);
/// # Ok::<(), gp_core::GpError>(())
/// ```
///
/// # Source
/// Snelson, Rasmussen & Ghahramani, Warped Gaussian processes (2004).
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Warped<P> {
    transform: Transform,
    latent: P,
}

impl<P: Posterior> Warped<P> {
    /// Learns from transformed outputs.
    ///
    /// - `y`: outputs, positive; - `fit`: makes the posterior of the z that it is given.
    ///
    /// # Errors
    /// As [`Transform::forward`]; those of `fit`.
    pub fn fit(
        transform: Transform,
        y: &[f64],
        fit: impl FnOnce(&[f64]) -> Result<P, GpError>,
    ) -> Result<Self, GpError> {
        Ok(Self { transform, latent: fit(&transform.forward(y)?)? })
    }

    /// The transform g.
    pub fn transform(&self) -> Transform {
        self.transform
    }

    /// The posterior about f, in the unit of z.
    pub fn latent(&self) -> &P {
        &self.latent
    }

    /// Quantiles of an observation at each input, M×L, one level a column; level 0.5 is the median.
    ///
    /// # Errors
    /// As `Posterior::predict`; `InvalidLevel` for one outside (0, 1).
    pub fn quantiles<'a>(
        &self,
        x_star: impl Into<Inputs<'a>>,
        levels: &[f64],
    ) -> Result<Mat<f64>, GpError> {
        if let Some(&level) = levels.iter().find(|level| !(**level > 0.0 && **level < 1.0)) {
            return Err(GpError::InvalidLevel { level });
        }
        let (mean, variance) = self.observation(x_star.into().matrix())?;
        let places: Vec<f64> = levels.iter().map(|level| quantile::normal(*level)).collect();
        Ok(Mat::from_fn(mean.len(), levels.len(), |i, j| {
            self.transform.inverse(mean[i] + variance[i].sqrt() * places[j])
        }))
    }

    /// Mean and variance of an observation at each input.
    ///
    /// # Errors
    /// As `Posterior::predict`; `NotFinite` where a variance is beyond all numbers.
    pub fn moments<'a>(
        &self,
        x_star: impl Into<Inputs<'a>>,
    ) -> Result<(Vec<f64>, Vec<f64>), GpError> {
        let (mean, variance) = self.observation(x_star.into().matrix())?;
        let moments = |(m, v): (&f64, &f64)| self.integrate(*m, v.sqrt());
        let (mean, variance): (Vec<f64>, Vec<f64>) =
            mean.iter().zip(&variance).map(moments).unzip();
        check_outputs("mean of the output", &mean, mean.len())?;
        check_outputs("variance of the output", &variance, variance.len())?;
        Ok((mean, variance))
    }

    /// Log densities of observations `y`, one an input, in nats per unit of the output.
    ///
    /// # Errors
    /// As `Posterior::predict` and [`Transform::forward`]; `ShapeMismatch` if there is not one a row.
    pub fn log_density<'a>(
        &self,
        x_star: impl Into<Inputs<'a>>,
        y: &[f64],
    ) -> Result<Vec<f64>, GpError> {
        let (mean, variance) = self.observation(x_star.into().matrix())?;
        check_outputs("observations", y, mean.len())?;
        let z = self.transform.forward(y)?;
        let density = |i: usize| {
            let error = z[i] - mean[i];
            let gaussian = error * error / variance[i] + (2.0 * PI * variance[i]).ln();
            self.transform.log_slope(y[i]) - 0.5 * gaussian
        };
        Ok((0..y.len()).map(density).collect())
    }

    fn observation(&self, x_star: MatRef<'_, f64>) -> Result<(Vec<f64>, Vec<f64>), GpError> {
        self.latent.predict_observation(x_star)
    }

    /// Mean and variance of y with z ~ N(mean, sd²).
    fn integrate(&self, mean: f64, sd: f64) -> (f64, f64) {
        if self.transform == Transform::Log {
            let center = (mean + 0.5 * sd * sd).exp();
            return (center, center * center * (sd * sd).exp_m1());
        }
        let node = |i: i32| 0.05 * f64::from(i);
        let terms = (-180..=180).map(|i| {
            let weight = (-0.5 * node(i) * node(i)).exp();
            (weight, self.transform.inverse(mean + sd * node(i)))
        });
        let total: f64 = terms.clone().map(|(weight, _)| weight).sum();
        let center = terms.clone().map(|(weight, y)| weight * y).sum::<f64>() / total;
        let spread = terms.map(|(weight, y)| weight * (y - center).powi(2)).sum::<f64>() / total;
        (center, spread)
    }
}
