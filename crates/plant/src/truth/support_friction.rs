//! Friction between object and table.

use serde::{Deserialize, Serialize};

use super::RateLaw;

/// The friction under the object.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SupportFriction {
    /// Coulomb coefficient.
    pub coefficient: f64,
    /// Relative rise from the first push of the set to the last; none in the middle of the set.
    pub drift: f64,
    /// How it depends on the speed.
    pub rate: RateLaw,
}

impl Default for SupportFriction {
    fn default() -> Self {
        Self { coefficient: 0.25, drift: 0.0, rate: RateLaw::default() }
    }
}
