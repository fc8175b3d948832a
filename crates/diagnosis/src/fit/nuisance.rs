//! Nominal numbers that every fit leaves open within their tolerances.

use serde::Serialize;

/// An effect that a fit moves beside those asked for, so that a nominal number that is a little
/// wrong is not taken for something else.
///
/// The prior of each of its coordinates is normal about the nominal value, with the standard
/// deviation √(absolute² + (relative · nominal)²).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Nuisance {
    /// Id of the effect.
    pub id: &'static str,
    /// Absolute tolerance, in the unit of its coordinates.
    pub absolute: f64,
    /// Tolerance relative to the nominal value.
    pub relative: f64,
}

impl Nuisance {
    /// What a carefully measured rig leaves open: the friction of the pusher within 3 % and the
    /// characteristic length within 1 %, the pusher's radius and the tracked frame within 0.1 mm
    /// and 0.2°, the streams' clocks within 2 ms, the contact's compliance within 20 µm/N.
    pub const STANDARD: [Self; 7] = [
        Self::relative("pressure-radius", 0.01),
        Self::relative("pusher-friction", 0.03),
        Self::absolute("pusher-radius", 1e-4),
        Self::absolute("pusher-compliance", 2e-5),
        Self::absolute("pose-offset", 1e-4),
        Self::absolute("yaw-offset", 3.5e-3),
        Self::absolute("stream-latency", 2e-3),
    ];

    /// The friction of the pusher and the characteristic length alone, with their tolerances.
    pub const NOMINAL: [Self; 2] = [Self::STANDARD[0], Self::STANDARD[1]];

    const fn relative(id: &'static str, relative: f64) -> Self {
        Self { id, absolute: 0.0, relative }
    }

    const fn absolute(id: &'static str, absolute: f64) -> Self {
        Self { id, absolute, relative: 0.0 }
    }

    /// The standard deviation about a nominal value.
    pub(super) fn sd(&self, nominal: f64) -> f64 {
        self.absolute.hypot(self.relative * nominal)
    }
}
