//! The pushes that a model predicts worst.

use effects::Channels;
use serde::Serialize;

use crate::{ChannelError, Observations, PushName};

/// A push with its errors.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WorstPush {
    /// Which push.
    #[serde(flatten)]
    pub name: PushName,
    /// Steps compared.
    pub n_steps: usize,
    /// Root mean square error of dx, dy (m) and dtheta (rad) of a step.
    pub rms: [f64; 3],
    /// Root mean square of the three, each over its value in the whole set.
    pub over_mean: f64,
}

/// The worst `n` pushes by their motion, the worst first.
pub(crate) fn worst_pushes(
    residuals: &[[Option<f64>; 7]],
    observations: &Observations,
    channels: &[ChannelError],
    n: usize,
) -> Vec<WorstPush> {
    let of_set = |k: usize| channels.iter().find(|error| error.name == Channels::NAMES[k]);
    let mut sums = vec![([0.0; 3], 0_usize); observations.pushes.len()];
    for (values, push) in residuals.iter().zip(&observations.push_of) {
        sums[*push].1 += 1;
        for (sum, value) in sums[*push].0.iter_mut().zip(values) {
            *sum += value.map_or(0.0, |value| value * value);
        }
    }
    let worst = |(push, (sums, n_steps)): (usize, &([f64; 3], usize))| {
        let rms = sums.map(|sum| (sum / *n_steps as f64).sqrt());
        let ratio = |k: usize| match of_set(k) {
            Some(error) if error.rms > 0.0 => (rms[k] / error.rms).powi(2),
            _ => 0.0,
        };
        let over_mean = ((0..3).map(ratio).sum::<f64>() / 3.0).sqrt();
        WorstPush { name: observations.pushes[push].clone(), n_steps: *n_steps, rms, over_mean }
    };
    let mut pushes: Vec<_> = sums.iter().enumerate().map(worst).collect();
    pushes.sort_by(|a, b| b.over_mean.total_cmp(&a.over_mean));
    pushes.truncate(n);
    pushes
}
