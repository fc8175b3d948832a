//! How the support's load is spread.

use serde::{Deserialize, Serialize};

use super::Feet;

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
    /// Share of the load that is near the outline, over what uniform pressure has there. Between 0 and 1.
    #[serde(skip_serializing_if = "is_zero")]
    pub rim_share: f64,
    /// Feet that bear a part of the load.
    #[serde(skip_serializing_if = "Feet::is_off")]
    pub feet: Feet,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes references")]
fn is_zero(share: &f64) -> bool {
    *share == 0.0
}

impl Default for Pressure {
    fn default() -> Self {
        Self {
            radius_ratio: 1.0,
            center_shift: [0.0; 2],
            patch_share: 1.0,
            rim_share: 0.0,
            feet: Feet::default(),
        }
    }
}
