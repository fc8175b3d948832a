//! The steps that a learnt model has seen: beyond them it guesses.

use serde::{Deserialize, Serialize};

use crate::{ModelError, StepFeatures, StepInput};

/// What the training steps of a learnt model span.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SeenSteps {
    /// Least and largest value of each input, in the order of the inputs.
    pub inputs: Vec<[f64; 2]>,
    /// Shortest and longest way of the pusher in a step, in m.
    pub way: [f64; 2],
}

/// Inputs beyond the span by less than this share of it are within.
const MARGIN: f64 = 0.02;
/// A step this much longer than the longest is as long.
const SLACK: f64 = 1.05;

impl SeenSteps {
    /// The span of some steps' inputs; none of no steps.
    pub(crate) fn of(
        features: StepFeatures,
        steps: &[&StepInput],
    ) -> Result<Option<Self>, ModelError> {
        let rows = features.rows(steps.iter().copied())?;
        let span = |values: &mut dyn Iterator<Item = f64>| {
            values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
                [low.min(value), high.max(value)]
            })
        };
        let inputs = (0..rows.ncols()).map(|d| span(&mut rows.col(d).iter().copied())).collect();
        let way = span(&mut steps.iter().map(|step| step.distance()));
        Ok((!steps.is_empty()).then_some(Self { inputs, way }))
    }

    /// Whether a step's inputs, in their order, are within what was seen.
    pub(crate) fn holds(&self, inputs: &[f64]) -> bool {
        let mut pairs = inputs.iter().zip(&self.inputs);
        pairs.all(|(value, [low, high])| {
            let margin = MARGIN * (high - low);
            (low - margin..=high + margin).contains(value)
        })
    }

    /// Refuses a step, of so many m, that is longer than any that was seen.
    ///
    /// # Errors
    /// `StepTooLong`.
    pub fn check_way(&self, way: f64) -> Result<(), ModelError> {
        let longest = self.way[1];
        if way <= SLACK * longest { Ok(()) } else { Err(ModelError::StepTooLong { way, longest }) }
    }

    /// Whether the numbers belong to so many inputs.
    pub(crate) fn is_sound(&self, n_inputs: usize) -> bool {
        let ordered = |[low, high]: &[f64; 2]| low <= high && (high - low).is_finite();
        self.inputs.len() == n_inputs
            && self.inputs.iter().all(ordered)
            && ordered(&self.way)
            && self.way[0] > 0.0
    }
}
