//! Mass and its center.

use serde::{Deserialize, Serialize};

/// How mass differs from what is nominally known of it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Body {
    /// True over nominal mass; the moment of inertia goes with it.
    pub mass_ratio: f64,
    /// Center of mass away from the nominal one, in m, body frame.
    pub center_shift: [f64; 2],
}

impl Default for Body {
    fn default() -> Self {
        Self { mass_ratio: 1.0, center_shift: [0.0; 2] }
    }
}
