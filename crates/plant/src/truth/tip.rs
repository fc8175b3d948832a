//! The pusher's tip and what holds it.

use serde::{Deserialize, Serialize};

/// A round tip on a spring and a damper, whose other end follows the robot's path exactly.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Tip {
    /// Radius, in m; 0 for a point.
    pub radius: f64,
    /// How high above the table it pushes, and the center of mass is, in m: against the table's friction
    /// the load moves forward, under an impact it does not. Felt where the underside has a stiffness.
    pub height: f64,
    /// Compliance of tip and arm in every direction, in m/N.
    pub compliance: f64,
    /// Damping of the object's swing on this spring, as a share of the critical one.
    pub damping_ratio: f64,
    /// How far the force acts from the geometrical contact, in m along the outline's tangent (the
    /// inward normal turned by +90°).
    pub bias: f64,
    /// A part of the tip that slips inside and so remembers.
    pub hysteresis: Hysteresis,
}

/// A second spring beside the tip's, held by a dry friction that gives way.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Hysteresis {
    /// Stiffness of the second spring, in N/m.
    pub stiffness: f64,
    /// Force at which it slips, in N.
    pub yield_force: f64,
}

impl Default for Tip {
    fn default() -> Self {
        Self {
            radius: 0.00475,
            height: 0.0,
            compliance: 2e-5,
            damping_ratio: 0.4,
            bias: 0.0,
            hysteresis: Hysteresis::default(),
        }
    }
}

impl Default for Hysteresis {
    fn default() -> Self {
        Self { stiffness: 0.0, yield_force: 1.0 }
    }
}
