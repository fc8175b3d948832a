//! From one model's error to another's, on the same steps.

use effects::Channels;
use serde::Serialize;

use crate::compare::errors::{UNITS, of_number};
use crate::data::clusters::ClusterMean;
use crate::{DiagnosisError, NoiseFloor, Observations, Predictions};

/// How the error in one number of a step changes from one model to another.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChannelChange {
    /// Which number.
    pub name: &'static str,
    /// Its SI unit.
    pub unit: &'static str,
    /// Root mean square error of the first model.
    pub before: f64,
    /// Of the second.
    pub after: f64,
    /// Mean change of the squared error of a step, second less first: negative is better.
    pub square_change: f64,
    /// Its standard error, from the differences of whole clusters.
    pub square_change_se: f64,
    /// Share of the pushes whose error falls.
    pub better_share: f64,
    /// (before − after)/(before − floor); none where the first model is at the floor.
    pub gap_closed: Option<f64>,
}

/// The change of each number that both models predict.
///
/// # Errors
/// `OtherSteps` if predictions are of other observations.
pub fn change(
    observations: &Observations,
    before: &Predictions,
    after: &Predictions,
    floor: &NoiseFloor,
) -> Result<Vec<ChannelChange>, DiagnosisError> {
    let (before, after) = (before.residuals(observations)?, after.residuals(observations)?);
    let of = |number: usize| {
        let square = |residuals: &[[Option<f64>; 7]]| -> Vec<(usize, f64)> {
            let values = of_number(residuals, &observations.cluster_of, number);
            values.into_iter().map(|(cluster, value)| (cluster, value * value)).collect()
        };
        let (first, second) = (square(&before), square(&after));
        if first.len() != second.len() {
            return None;
        }
        let (old, new) =
            (ClusterMean::of(&first)?.mean.sqrt(), ClusterMean::of(&second)?.mean.sqrt());
        let pairs = first.iter().zip(&second);
        let changes: Vec<_> =
            pairs.map(|((cluster, old), (_, new))| (*cluster, new - old)).collect();
        let mean = ClusterMean::of(&changes)?;
        let pushes = of_number(&before, &observations.push_of, number);
        let pushes: Vec<_> =
            pushes.iter().zip(&changes).map(|((push, _), c)| (*push, c.1)).collect();
        let sums: Vec<f64> = pushes
            .chunk_by(|a, b| a.0 == b.0)
            .map(|push| push.iter().map(|(_, change)| change).sum())
            .collect();
        let n_better = sums.iter().filter(|sum| **sum < 0.0).count();
        let floor = floor.numbers[number].filter(|floor| floor.high95 < old);
        Some(ChannelChange {
            name: Channels::NAMES[number],
            unit: UNITS[number],
            before: old,
            after: new,
            square_change: mean.mean,
            square_change_se: mean.se,
            better_share: n_better as f64 / sums.len() as f64,
            gap_closed: floor.map(|floor| (old - new) / (old - floor.rms)),
        })
    };
    Ok((0..Channels::NAMES.len()).filter_map(of).collect())
}
