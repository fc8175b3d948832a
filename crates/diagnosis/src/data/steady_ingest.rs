//! How recordings are read for a diagnosis.

use dataset::{Curve, IngestSettings, StepLength};

/// Way of a step, in m, and its least time, in s.
pub(crate) const STEP_WAY: f64 = 5e-3;
pub(crate) const STEP_TIME: f64 = 0.05;
/// Way and time of the first touch, in m and s.
pub(crate) const FIRST_WAY: f64 = 2e-3;
pub(crate) const FIRST_TIME: f64 = 0.03;

/// Settings with which recordings become steps of little noise: steps of 5 mm and at least 50 ms
/// between smooth curves that are fitted to the contact alone.
///
/// A difference of two samples is four times as noisy. The first 2 mm and 30 ms of a push count as
/// its first touch, see [`crate::Observations::steady`]: the impact swings for that long, and a step
/// that begins within it has an unknown share of its impulse.
pub fn steady_ingest() -> IngestSettings {
    IngestSettings {
        step: StepLength::Distance(STEP_WAY),
        least_step_time: STEP_TIME,
        curve: Curve::Smooth,
        first_touch_time: FIRST_TIME,
        first_touch_way: FIRST_WAY,
        ..IngestSettings::default()
    }
}
