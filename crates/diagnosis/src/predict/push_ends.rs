//! How far off a model is at the end of whole pushes.

use serde::Serialize;

use crate::{PushName, Rollout};

/// Errors at the end of pushes that were rolled out.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PushEnds {
    /// Distance between the predicted and the measured place of the object, in m.
    pub position: Spread,
    /// Size of the difference of their angles, in rad.
    pub angle: Spread,
    /// Pushes in which the model's object gets away from the pusher, which it does not in truth.
    pub n_lost: usize,
    /// Each push, in the order of the table.
    pub pushes: Vec<PushEnd>,
}

/// How errors are spread over pushes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// Mean.
    pub mean: f64,
    /// Median.
    pub median: f64,
    /// 90th percentile.
    pub p90: f64,
}

/// One push with its errors at the end.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PushEnd {
    /// Which push.
    #[serde(flatten)]
    pub name: PushName,
    /// Steps rolled out.
    pub n_steps: usize,
    /// The pusher's way, in m.
    pub way: f64,
    /// Distance between the predicted and the measured end, in m.
    pub position_error: f64,
    /// Predicted less measured angle at the end, in rad, counter-clockwise positive.
    pub angle_error: f64,
    /// Whether the model's object gets away from the pusher.
    pub lost_contact: bool,
}

/// Gap from which contact counts as lost, in m.
const LOST: f64 = 1e-3;

/// The errors at the end of roll-outs of more than one step, and of whole pushes that are one; none if
/// there is no such push.
pub fn push_ends(rollouts: &[Rollout]) -> Option<PushEnds> {
    let is_long = |rollout: &&Rollout| rollout.times.len() > 2 || rollout.is_whole;
    let long = rollouts.iter().filter(is_long);
    let pushes: Vec<PushEnd> = long.map(push_end).collect();
    if pushes.is_empty() {
        return None;
    }
    let spread = |value: fn(&PushEnd) -> f64| Spread::of(pushes.iter().map(value).collect());
    Some(PushEnds {
        position: spread(|push| push.position_error),
        angle: spread(|push| push.angle_error.abs()),
        n_lost: pushes.iter().filter(|push| push.lost_contact).count(),
        pushes,
    })
}

fn push_end(rollout: &Rollout) -> PushEnd {
    let (position_error, angle_error) = rollout.end_error();
    PushEnd {
        name: rollout.push.clone(),
        n_steps: rollout.times.len() - 1,
        way: rollout.pusher_w.windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum(),
        position_error,
        angle_error,
        // Of a whole push it is not known whether it does so in truth.
        lost_contact: !rollout.is_whole && rollout.gaps.iter().any(|gap| *gap > LOST),
    }
}

impl Spread {
    /// Of values of which there is at least one; percentiles are linear between them.
    fn of(mut values: Vec<f64>) -> Self {
        values.sort_by(f64::total_cmp);
        let at = |share: f64| {
            let place = share * (values.len() - 1) as f64;
            let (low, high) = (values[place.floor() as usize], values[place.ceil() as usize]);
            low + place.fract() * (high - low)
        };
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        Self { mean, median: at(0.5), p90: at(0.9) }
    }
}

#[cfg(test)]
mod tests {
    use super::Spread;

    #[test]
    fn percentiles_are_linear_between_the_values() {
        let spread = Spread::of(vec![4.0, 0.0, 1.0, 2.0, 3.0]);
        assert_eq!((spread.mean, spread.median), (2.0, 2.0));
        assert!((spread.p90 - 3.6).abs() < 1e-12);
    }
}
