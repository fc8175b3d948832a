//! How recordings are read for a diagnosis.

use dataset::{Curve, IngestSettings, StepLength};

/// Settings with which recordings become steps of little noise: steps of 5 mm and at least 50 ms
/// between smooth curves that are fitted to the contact alone.
///
/// A difference of two samples is four times as noisy. The first 2 mm and 30 ms of a push count as
/// its first touch, see [`crate::Observations::steady`]: the impact swings for that long, and a step
/// that begins within it has an unknown share of its impulse.
pub fn steady_ingest() -> IngestSettings {
    IngestSettings {
        step: StepLength::Distance(5e-3),
        least_step_time: 0.05,
        curve: Curve::Smooth,
        first_touch_time: 0.03,
        first_touch_way: 2e-3,
        ..IngestSettings::default()
    }
}
