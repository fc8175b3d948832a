//! How the support's load is spread.

use serde::{Deserialize, Serialize};

/// The pressure under the object, against uniform pressure.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Pressure {
    /// Mean distance of the load from its center over that of uniform pressure.
    pub radius_ratio: f64,
    /// Center of pressure away from the outline's centroid, in m, body frame.
    pub center_shift: [f64; 2],
    /// Share of the load on pads all over the outline; the rest rests on one plate that dissipates
    /// √(|v|² + c²ω²) per load, whose limit surface is an ellipsoid. Between 0 and 1.
    pub patch_share: f64,
}

impl Default for Pressure {
    fn default() -> Self {
        Self { radius_ratio: 1.0, center_shift: [0.0; 2], patch_share: 1.0 }
    }
}
