//! How one push differs from the next.

use serde::{Deserialize, Serialize};

/// Departures of one push from what is true of the set.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Variation {
    /// Factor on the support's friction.
    pub support_friction: f64,
    /// Factor on the tip's friction.
    pub tip_friction: f64,
    /// Factor on the mean distance of the pressure from its center.
    pub pressure_radius: f64,
    /// Shift of the center of pressure, in m, body frame.
    pub pressure_shift: [f64; 2],
    /// Shift of the place where the tip's force acts, in m along the tangent.
    pub contact_shift: f64,
    /// Added to the readings of the loaded force sensor, in N, world frame.
    pub force_bias: [f64; 2],
    /// Share of the push after which the force sensor's zero is lost; 1 if it is not.
    pub zero_kept: f64,
    /// How much further away the tip starts than planned, in m.
    pub gap: f64,
    /// Where on the table it takes place instead of where it was planned, object and path: x, y in m.
    pub shift: [f64; 2],
}

impl Default for Variation {
    fn default() -> Self {
        Self {
            support_friction: 1.0,
            tip_friction: 1.0,
            pressure_radius: 1.0,
            pressure_shift: [0.0; 2],
            contact_shift: 0.0,
            force_bias: [0.0; 2],
            zero_kept: 1.0,
            gap: 0.0,
            shift: [0.0; 2],
        }
    }
}
