//! Feet under the object.

use serde::{Deserialize, Serialize};

/// Three feet, each at the same part of the way from the center of mass to the outline, a third of a turn
/// apart, that share what they bear as statics have it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Feet {
    /// Share of the weight that rests on them, between 0 and 1.
    pub share: f64,
    /// Part of the way to the outline, between 0 and 1.
    pub reach: f64,
    /// Direction of the first from the center of mass, in rad, body frame.
    pub direction: f64,
}

impl Feet {
    pub(crate) fn is_off(&self) -> bool {
        self.share == 0.0
    }
}

impl Default for Feet {
    fn default() -> Self {
        Self { share: 0.0, reach: 0.8, direction: 0.0 }
    }
}
