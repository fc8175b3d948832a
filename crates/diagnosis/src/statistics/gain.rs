//! Log predictive density that clusters gain from one model to another.

use crate::cut_offs::{MOST_OF_ONE, SURE_NATS, SURE_SE};
use serde::{Deserialize, Serialize};

/// Log predictive density that held-out pushes gain, in nats, with its standard error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gain {
    /// The sum over clusters, none of which counts for more than 10, in nats.
    pub mean: f64,
    /// Its standard error, from whole clusters.
    pub se: f64,
}

impl Gain {
    /// Of the gains of clusters, none of which says more than 10 nats.
    pub(crate) fn of(gains: &[f64]) -> Self {
        let n = gains.len() as f64;
        let capped = || gains.iter().map(|gain| gain.clamp(-MOST_OF_ONE, MOST_OF_ONE));
        let mean = capped().sum::<f64>() / n;
        let squares = capped().map(|gain| (gain - mean).powi(2)).sum::<f64>();
        Self { mean: n * mean, se: (n * squares / (n - 1.0).max(1.0)).sqrt() }
    }

    /// Whether pushes that no fit has seen are predicted better for sure.
    pub fn is_sure(&self) -> bool {
        self.mean >= SURE_NATS.max(SURE_SE * self.se)
    }
}

#[cfg(test)]
mod tests {
    use super::Gain;

    #[test]
    fn few_pushes_confirm_nothing_however_much_they_gain() {
        let gains =
            |n: usize| (0..20).map(|k| if k < n { 4000.0 } else { 0.0 }).collect::<Vec<_>>();
        let [few, many] = [2, 12].map(|n| Gain::of(&gains(n)));
        assert_eq!((few.mean, many.mean), (20.0, 120.0));
        assert!(!few.is_sure() && many.is_sure());
        assert!(!Gain { mean: 3.0, se: 0.1 }.is_sure());
    }
}
