//! The ways in which a residual is read.

use effects::Channels;

use crate::compare::errors::UNITS;
use crate::{Observations, Predictions};

/// A number of a step, as it is or in the sense in which the model moves.
///
/// A model that turns every object too little misses counter-clockwise on one half of an edge and
/// clockwise on the other: only in the sense of the turn is it one fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Reading {
    pub(crate) name: &'static str,
    pub(crate) number: usize,
    in_sense: bool,
}

/// Predictions below this share of their root mean square have no sense.
const SENSELESS: f64 = 0.1;

impl Reading {
    /// Every number; Δy and Δθ also in the sense of the model.
    pub(crate) fn all() -> impl Iterator<Item = Self> {
        let plain = (0..Channels::NAMES.len()).map(|number| {
            let name = Channels::NAMES[number];
            Self { name, number, in_sense: false }
        });
        let senses = [("drift", 1), ("turn", 2)];
        plain.chain(senses.map(|(name, number)| Self { name, number, in_sense: true }))
    }

    pub(crate) fn unit(&self) -> &'static str {
        UNITS[self.number]
    }

    /// Whether it is in the sense that the model predicts.
    pub(crate) fn is_in_sense(&self) -> bool {
        self.in_sense
    }

    /// What each residual is to be multiplied by; 0 leaves a step out.
    pub(crate) fn signs(&self, predictions: &Predictions, observations: &Observations) -> Vec<f64> {
        self.signs_above(self.senseless(predictions), predictions, observations)
    }

    /// The same where predictions of this size and below have no sense.
    pub(crate) fn signs_above(
        &self,
        least: f64,
        predictions: &Predictions,
        observations: &Observations,
    ) -> Vec<f64> {
        if !self.in_sense {
            return vec![1.0; observations.n_steps()];
        }
        let sign = |value: Option<f64>| match value {
            Some(value) if value.abs() > least => value.signum(),
            _ => 0.0,
        };
        self.predicted(predictions).map(sign).collect()
    }

    /// The largest size of a prediction that has no sense.
    pub(crate) fn senseless(&self, predictions: &Predictions) -> f64 {
        let squares = self.predicted(predictions).flatten().map(|value| value * value).sum::<f64>();
        SENSELESS * (squares / predictions.values.len() as f64).sqrt()
    }

    fn predicted(&self, predictions: &Predictions) -> impl Iterator<Item = Option<f64>> {
        predictions.values.iter().map(|values| values[self.number])
    }
}
