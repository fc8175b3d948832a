//! The error of each number of a step.

use effects::{Channel, Channels};
use serde::Serialize;

use crate::data::clusters::ClusterMean;
use crate::{Floor, NoiseFloor, Observations};

/// How wrong a model is in one number of a step.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChannelError {
    /// Which number, as in the table.
    pub name: &'static str,
    /// Its channel.
    pub channel: Channel,
    /// SI unit of everything here but `nmse` and the ratios.
    pub unit: &'static str,
    /// Steps that have it, observed and predicted.
    pub n_steps: usize,
    /// Root mean square of observed less predicted.
    pub rms: f64,
    /// Standard error of `rms`, from whole clusters.
    pub rms_se: f64,
    /// Mean of observed less predicted.
    pub bias: f64,
    /// Standard error of `bias`, from whole clusters.
    pub bias_se: f64,
    /// Mean square over the variance of what was observed: 1 for a model that predicts its mean;
    /// none where it does not vary.
    pub nmse: Option<f64>,
    /// The least error that a model can have.
    pub floor: Option<Floor>,
    /// `rms` over the floor's.
    pub over_floor: Option<f64>,
}

/// SI unit of each number of a step.
pub(crate) const UNITS: [&str; 7] = ["m", "m", "rad", "N", "N", "m", "m"];

impl ChannelError {
    /// - `number`: which; `bias` and `square`: means of its residuals and of their squares.
    /// - `spread`: variance of what was observed.
    pub(crate) fn of(
        number: usize,
        [bias, square]: [ClusterMean; 2],
        spread: f64,
        floor: Option<Floor>,
    ) -> Self {
        let rms = square.mean.sqrt();
        Self {
            name: Channels::NAMES[number],
            channel: Channels::KINDS[number],
            unit: UNITS[number],
            n_steps: bias.n_steps,
            rms,
            rms_se: if rms > 0.0 { 0.5 * square.se / rms } else { 0.0 },
            bias: bias.mean,
            bias_se: bias.se,
            nmse: (spread > 0.0).then(|| square.mean / spread),
            floor,
            over_floor: floor.filter(|floor| floor.rms > 0.0).map(|floor| rms / floor.rms),
        }
    }
}

/// The residuals of one number, with an index of each step, as of its cluster.
pub(crate) fn of_number(
    residuals: &[[Option<f64>; 7]],
    index_of: &[usize],
    number: usize,
) -> Vec<(usize, f64)> {
    let values = residuals.iter().zip(index_of);
    values.filter_map(|(values, index)| Some((*index, values[number]?))).collect()
}

/// The errors of each number that enough pushes have.
pub(crate) fn channel_errors(
    residuals: &[[Option<f64>; 7]],
    observations: &Observations,
    floor: &NoiseFloor,
) -> Vec<ChannelError> {
    let error = |number: usize| {
        let values = of_number(residuals, &observations.cluster_of, number);
        let bias = ClusterMean::of(&values)?;
        let squares: Vec<_> = values.iter().map(|(push, value)| (*push, value * value)).collect();
        let square = ClusterMean::of(&squares)?;
        let spread = spread(residuals, observations, number);
        Some(ChannelError::of(number, [bias, square], spread, floor.numbers[number]))
    };
    (0..Channels::NAMES.len()).filter_map(error).collect()
}

/// Variance about its mean of what was observed where there is a residual.
fn spread(residuals: &[[Option<f64>; 7]], observations: &Observations, number: usize) -> f64 {
    let steps = residuals.iter().zip(&observations.steps);
    let observed: Vec<f64> = steps
        .filter(|(values, _)| values[number].is_some())
        .filter_map(|(_, step)| step.observed[number])
        .collect();
    let mean = observed.iter().sum::<f64>() / observed.len() as f64;
    observed.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / observed.len() as f64
}
