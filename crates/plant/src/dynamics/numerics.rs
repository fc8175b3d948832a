//! How finely the plant is simulated.

use serde::{Deserialize, Serialize};

/// Resolution in space and time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Numerics {
    /// Pads under the object, about; at least 100.
    pub n_pads: usize,
    /// Difference between a whole and two half steps that is allowed, in m (turns count times the
    /// radius, rates times the swing time on the tip); the result, which is
    /// extrapolated from both, is far better.
    pub tolerance: f64,
    /// Longest step, in s.
    pub longest_step: f64,
    /// Speed at which a loaded pad creeps below its limit of friction, in m/s: v/√(v² + creep²) of its
    /// friction resists at v.
    ///
    /// An object that the tip does not push rests all the same, up to 97 % of the limit. One that the
    /// tip holds with a share s of the limit creeps at s/√(1 − s²) times this.
    pub creep: f64,
}

impl Default for Numerics {
    fn default() -> Self {
        Self { n_pads: 256, tolerance: 5e-8, longest_step: 5e-3, creep: 5e-5 }
    }
}
