//! How recordings are read for a diagnosis.

use dataset::{Curve, IngestSettings, StepLength};

/// Way of a step, in m, and its least time, in s.
pub(crate) const STEP_WAY: f64 = 5e-3;
pub(crate) const STEP_TIME: f64 = 0.05;

/// Settings with which recordings become steps of little noise: steps of 5 mm and at least 50 ms
/// between smooth curves that are fitted to the contact alone.
///
/// A difference of two samples is four times as noisy. The first 2 mm of a push count as its first
/// touch, see [`crate::Observations::steady`].
pub fn steady_ingest() -> IngestSettings {
    IngestSettings {
        step: StepLength::Distance(STEP_WAY),
        least_step_time: STEP_TIME,
        curve: Curve::Smooth,
        first_touch_time: 0.0,
        first_touch_way: 2e-3,
        ..IngestSettings::default()
    }
}
