//! Friction between tip and object.

use libm::exp;
use serde::{Deserialize, Serialize};

use super::Texture;

/// Coulomb friction at the tip.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TipFriction {
    /// Coefficient in sliding.
    pub coefficient: f64,
    /// (left − right)/mean: left is a tip that slides along the inward normal turned by +90°.
    pub asymmetry: f64,
    /// Coefficient at rest over that in sliding.
    pub static_ratio: f64,
    /// Sliding speed over which it falls from one to the other, in m/s.
    pub stribeck_speed: f64,
    /// Relative departures along the object's sides.
    pub texture: Texture,
}

impl Default for TipFriction {
    fn default() -> Self {
        Self {
            coefficient: 0.25,
            asymmetry: 0.0,
            static_ratio: 1.0,
            stribeck_speed: 0.001,
            texture: Texture::default(),
        }
    }
}

impl TipFriction {
    /// Coefficient for a tip that slides, or is about to slide, to a side (+1 left, −1 right) with
    /// a speed, in m/s.
    pub(crate) fn at(&self, side: f64, speed: f64) -> f64 {
        let mut coefficient = self.coefficient * (1.0 + 0.5 * side * self.asymmetry);
        if self.static_ratio != 1.0 {
            let v = speed / self.stribeck_speed;
            coefficient *= 1.0 + (self.static_ratio - 1.0) * exp(-v * v);
        }
        coefficient
    }
}

#[cfg(test)]
mod tests {
    use super::TipFriction;

    #[test]
    fn sides_differ_by_the_asymmetry_and_rest_by_the_static_ratio() {
        let friction = TipFriction { asymmetry: 0.2, static_ratio: 1.5, ..TipFriction::default() };
        assert!((friction.at(1.0, 1.0) / friction.at(-1.0, 1.0) - 1.1 / 0.9).abs() < 1e-15);
        assert!((friction.at(1.0, 0.0) / friction.at(1.0, 1.0) - 1.5).abs() < 1e-15);
    }
}
