//! Friction over the table.

use libm::exp;
use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

use super::Texture;

/// Friction at a place of the table, relative to the support's coefficient.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FrictionMap {
    /// Relative rise along x and y of the world, in 1/m; 0 rise at the table's origin.
    pub gradient: [f64; 2],
    /// A spot with another friction.
    pub spot: Spot,
    /// Relative departures all over the table.
    pub texture: Texture,
}

/// A round spot that rubs more, or less, with a soft rim.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Spot {
    /// Its center, in m, world frame.
    pub center: [f64; 2],
    /// Distance at which its increase has fallen to 37 %, in m.
    pub radius: f64,
    /// Relative increase of the friction at its center; -1 takes all friction away.
    pub increase: f64,
}

impl Default for Spot {
    fn default() -> Self {
        Self { center: [0.0; 2], radius: 0.03, increase: 0.0 }
    }
}

impl FrictionMap {
    /// Whether friction is the same everywhere, but for the texture.
    pub(crate) fn is_off(&self) -> bool {
        self.gradient == [0.0; 2] && self.spot.increase == 0.0
    }

    /// Factor on the friction at a place of the world (m), without the texture; never negative.
    pub(crate) fn factor(&self, place_w: &Vector2<f64>) -> f64 {
        let mut factor = 1.0 + Vector2::from(self.gradient).dot(place_w);
        if self.spot.increase != 0.0 {
            let away = (place_w - Vector2::from(self.spot.center)) / self.spot.radius;
            factor *= 1.0 + self.spot.increase * exp(-away.dot(&away));
        }
        factor.max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::{FrictionMap, Spot};
    use nalgebra::Vector2;

    #[test]
    fn gradient_and_spot_multiply() {
        let spot = Spot { center: [0.1, 0.0], increase: 1.0, ..Spot::default() };
        let map = FrictionMap { gradient: [2.0, 0.0], spot, ..FrictionMap::default() };
        assert!((map.factor(&Vector2::new(0.1, 0.0)) - 2.4).abs() < 1e-15);
        assert!((map.factor(&Vector2::new(-0.2, 0.0)) - 0.6).abs() < 1e-15);
        assert_eq!(map.factor(&Vector2::new(-1.0, 0.0)), 0.0);
    }
}
