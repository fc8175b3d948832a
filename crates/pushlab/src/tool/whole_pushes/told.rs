//! A calibration in a line.

use std::fmt;

use models::{Calibration, StepCorrelation};

/// How sure a model may be of whole pushes, in words.
pub(crate) struct Told<'a>(pub(crate) &'a Calibration);

impl fmt::Display for Told<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Calibration { n_pushes, widened, correlation, .. } = self.0;
        if let Some(StepCorrelation { held, length, n_pushes, .. }) = correlation {
            let [dx, dy, dtheta] = held.map(|share| format!("{share:.2}"));
            return write!(
                f,
                "of the model's variance of a step {dx} (dx), {dy} (dy), {dtheta} (dtheta) goes on over \
                 {:.0} mm of a push, by {n_pushes} pushes",
                1e3 * length
            );
        }
        write!(
            f,
            "what differs from push to push is drawn for each, {:.2} times as widely as in the model, by the \
             ends of {n_pushes} pushes",
            widened.unwrap_or(1.0)
        )
    }
}
