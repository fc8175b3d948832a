//! Scores of predictions against observations.
//!
//! `y` are N observations; `mean` and `variance` their N predictions, the variance including the
//! noise. Smaller is better for all but the coverage, which should equal its level.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use crate::GpError;
use crate::checks::{check_outputs, check_positive};

/// Root mean squared error √(Σ (y − mean)²/N), in the unit of the output.
///
/// # Errors
/// `Empty`, `ShapeMismatch`, `NotFinite`.
pub fn rmse(y: &[f64], mean: &[f64]) -> Result<f64, GpError> {
    Ok(mean_squared_error(y, mean)?.sqrt())
}

/// Normalised mean squared error: the mean squared error over the variance of `y` about its own
/// mean (both divided by N), so that predicting the mean of `y` everywhere scores 1.
///
/// # Errors
/// `Empty`, `ShapeMismatch`, `NotFinite`; `ConstantOutputs` if `y` has no variance.
pub fn nmse(y: &[f64], mean: &[f64]) -> Result<f64, GpError> {
    let error = mean_squared_error(y, mean)?;
    if y.iter().all(|value| *value == y[0]) {
        return Err(GpError::ConstantOutputs { value: y[0], n_rows: y.len() });
    }
    let center = average(y.iter().copied());
    Ok(error / average(y.iter().map(|y| (y - center).powi(2))))
}

/// Mean negative log predictive density −(1/N) Σ ln N(y | mean, variance), in nats.
///
/// # Errors
/// `Empty`, `ShapeMismatch`, `NotFinite`; `NotPositive` for a variance that is not.
pub fn nlpd(y: &[f64], mean: &[f64], variance: &[f64]) -> Result<f64, GpError> {
    check_gaussian(y, mean, variance)?;
    Ok(average(terms(y, mean, variance).map(negative_log_density)))
}

/// Mean standardised log loss: `nlpd` less that of the trivial model which predicts the mean and
/// variance of the training outputs everywhere, in nats; negative if better than trivial.
///
/// # Errors
/// As `nlpd`; `ConstantOutputs` if `y_train` has no variance.
///
/// # Source
/// Rasmussen & Williams, Gaussian Processes for Machine Learning (2006), ch. 2.
pub fn msll(y: &[f64], mean: &[f64], variance: &[f64], y_train: &[f64]) -> Result<f64, GpError> {
    let loss = nlpd(y, mean, variance)?;
    if y_train.is_empty() {
        return Err(GpError::Empty { what: "training outputs" });
    }
    check_outputs("training outputs", y_train, y_train.len())?;
    if y_train.iter().all(|value| *value == y_train[0]) {
        return Err(GpError::ConstantOutputs { value: y_train[0], n_rows: y_train.len() });
    }
    let center = average(y_train.iter().copied());
    let spread = average(y_train.iter().map(|y| (y - center).powi(2)));
    Ok(loss - average(y.iter().map(|y| negative_log_density((y - center, spread)))))
}

/// Mean continuous ranked probability score of Gaussian predictions, in the unit of the output.
///
/// s (z (2Φ(z) − 1) + 2φ(z) − 1/√π) with s² the variance and z = (y − mean)/s, averaged.
///
/// # Errors
/// As `nlpd`.
///
/// # Source
/// Gneiting & Raftery, Strictly proper scoring rules, prediction, and estimation (2007).
pub fn crps(y: &[f64], mean: &[f64], variance: &[f64]) -> Result<f64, GpError> {
    check_gaussian(y, mean, variance)?;
    Ok(average(terms(y, mean, variance).map(|(error, variance)| {
        let sd = variance.sqrt();
        let z = error / sd;
        let density = (-0.5 * z * z).exp() / (2.0 * PI).sqrt();
        sd * (z * libm::erf(z * FRAC_1_SQRT_2) + 2.0 * density - PI.sqrt().recip())
    })))
}

/// The fraction of observations within the central Gaussian interval of each level, e.g. 0.95.
///
/// # Errors
/// As `nlpd`; `InvalidLevel` for a level outside (0, 1).
pub fn coverage(
    y: &[f64],
    mean: &[f64],
    variance: &[f64],
    levels: &[f64],
) -> Result<Vec<f64>, GpError> {
    check_gaussian(y, mean, variance)?;
    let probabilities: Vec<f64> = terms(y, mean, variance)
        .map(|(error, variance)| libm::erf(error.abs() / variance.sqrt() * FRAC_1_SQRT_2))
        .collect();
    let fraction = |&level: &f64| {
        if level > 0.0 && level < 1.0 {
            let inside = probabilities.iter().filter(|&&probability| probability <= level).count();
            Ok(inside as f64 / y.len() as f64)
        } else {
            Err(GpError::InvalidLevel { level })
        }
    };
    levels.iter().map(fraction).collect()
}

/// The calibration curve: `coverage` at `n_levels` levels spread evenly over (0, 1), as pairs of
/// level and fraction; the diagonal if predictions are as uncertain as they say.
///
/// # Errors
/// As `nlpd`; `NotPositive` without levels.
pub fn calibration_curve(
    y: &[f64],
    mean: &[f64],
    variance: &[f64],
    n_levels: usize,
) -> Result<Vec<(f64, f64)>, GpError> {
    check_positive("n_levels", n_levels as f64)?;
    let level = |i: usize| (i as f64 + 0.5) / n_levels as f64;
    let levels: Vec<f64> = (0..n_levels).map(level).collect();
    let fractions = coverage(y, mean, variance, &levels)?;
    Ok(levels.into_iter().zip(fractions).collect())
}

/// Mean distance of the calibration curve of a hundred levels from the diagonal; 0 at best, and
/// never above ½.
///
/// # Errors
/// As `nlpd`.
pub fn calibration_error(y: &[f64], mean: &[f64], variance: &[f64]) -> Result<f64, GpError> {
    let curve = calibration_curve(y, mean, variance, 100)?;
    Ok(average(curve.iter().map(|(level, fraction)| (level - fraction).abs())))
}

fn mean_squared_error(y: &[f64], mean: &[f64]) -> Result<f64, GpError> {
    if y.is_empty() {
        return Err(GpError::Empty { what: "observations" });
    }
    check_outputs("observations", y, y.len())?;
    check_outputs("predicted means", mean, y.len())?;
    Ok(average(y.iter().zip(mean).map(|(y, mean)| (y - mean).powi(2))))
}

fn check_gaussian(y: &[f64], mean: &[f64], variance: &[f64]) -> Result<(), GpError> {
    mean_squared_error(y, mean)?;
    check_outputs("predicted variances", variance, y.len())?;
    for (row, &variance) in variance.iter().enumerate() {
        check_positive(&format!("predicted variance of row {row}"), variance)?;
    }
    Ok(())
}

/// Error and variance of each prediction.
fn terms<'a>(
    y: &'a [f64],
    mean: &'a [f64],
    variance: &'a [f64],
) -> impl ExactSizeIterator<Item = (f64, f64)> {
    y.iter().zip(mean).zip(variance).map(|((y, mean), variance)| (y - mean, *variance))
}

fn negative_log_density((error, variance): (f64, f64)) -> f64 {
    0.5 * (error * error / variance + (2.0 * PI * variance).ln())
}

fn average(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let n = values.len() as f64;
    values.sum::<f64>() / n
}
