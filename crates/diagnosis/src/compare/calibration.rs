//! Whether a model's own intervals hold what they claim.

use effects::Channels;
use gp_core::scores::{coverage, crps, nlpd};
use serde::Serialize;

use crate::compare::errors::UNITS;
use crate::{DiagnosisError, Observations, Predictions};

/// How honest a model is about one number of a step.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct IntervalCalibration {
    /// Which number.
    pub name: &'static str,
    /// Its SI unit.
    pub unit: &'static str,
    /// Steps with an interval.
    pub n_steps: usize,
    /// The central intervals of 50, 90 and 95 %.
    pub coverage: [Covered; 3],
    /// Mean negative log predictive density, in nats.
    pub nlpd: f64,
    /// Mean continuous ranked probability score, in the unit.
    pub crps: f64,
    /// The central intervals of 5 to 95 %.
    pub curve: Vec<Covered>,
}

/// A central interval and what it holds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Covered {
    /// What is claimed, 0 to 1.
    pub level: f64,
    /// The share of the observations in it.
    pub share: f64,
}

const LEVELS: [f64; 3] = [0.5, 0.9, 0.95];

impl IntervalCalibration {
    /// From numbers of steps within each interval, in the order of `coverage` and `curve`, Σ NLPD and Σ CRPS.
    pub(crate) fn of_sums(number: usize, n: f64, sums: &[f64]) -> Option<Self> {
        let (within, [nlpd, crps]) = sums.split_last_chunk()?;
        let (three, fine) = within.split_first_chunk::<3>()?;
        let covered = |(level, within): (f64, &f64)| Covered { level, share: within / n };
        Some(Self {
            name: Channels::NAMES[number],
            unit: UNITS[number],
            n_steps: n as usize,
            coverage: std::array::from_fn(|k| covered((LEVELS[k], &three[k]))),
            nlpd: nlpd / n,
            crps: crps / n,
            curve: fine_levels().zip(fine).map(covered).collect(),
        })
    }
}

/// Levels of a curve of calibration.
fn fine_levels() -> impl Iterator<Item = f64> {
    (1..20).map(|k| 0.05 * f64::from(k))
}

/// The calibration of each number that the model predicts with a variance.
pub(crate) fn calibrations(
    observations: &Observations,
    predictions: &Predictions,
) -> Result<Vec<IntervalCalibration>, DiagnosisError> {
    let numbers = 0..Channels::NAMES.len();
    numbers.filter_map(|number| of_number(observations, predictions, number).transpose()).collect()
}

fn of_number(
    observations: &Observations,
    predictions: &Predictions,
    number: usize,
) -> Result<Option<IntervalCalibration>, DiagnosisError> {
    let (mut y, mut mean, mut variance) = (Vec::new(), Vec::new(), Vec::new());
    for (index, step) in observations.steps.iter().enumerate() {
        let predicted = predictions.values[index][number];
        let spread = predictions.variances[index][number].filter(|spread| *spread > 0.0);
        if let (Some(observed), Some(value), Some(spread)) =
            (step.observed[number], predicted, spread)
        {
            y.push(observed);
            mean.push(value);
            variance.push(spread);
        }
    }
    if y.is_empty() {
        return Ok(None);
    }
    let fine: Vec<f64> = fine_levels().collect();
    let shares = |levels: &[f64]| coverage(&y, &mean, &variance, levels);
    let covered = |(level, share): (&f64, &f64)| Covered { level: *level, share: *share };
    let three = shares(&LEVELS)?;
    Ok(Some(IntervalCalibration {
        name: Channels::NAMES[number],
        unit: UNITS[number],
        n_steps: y.len(),
        coverage: std::array::from_fn(|k| covered((&LEVELS[k], &three[k]))),
        nlpd: nlpd(&y, &mean, &variance)?,
        crps: crps(&y, &mean, &variance)?,
        curve: fine.iter().zip(&shares(&fine)?).map(covered).collect(),
    }))
}
