//! A foot that does not always reach the table.

use libm::{sincos, tanh};
use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

/// An object that rocks a little: the push decides which side carries more of the load.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Wobble {
    /// Relative rise of the pressure at the loaded rim and its fall at the other one.
    pub share: f64,
    /// Direction along which it rocks, in rad, body frame.
    pub direction: f64,
    /// Push along that direction that rocks it, in N.
    pub force: f64,
}

impl Default for Wobble {
    fn default() -> Self {
        Self { share: 0.0, direction: 0.0, force: 0.3 }
    }
}

impl Wobble {
    /// Slope of the pressure, relative, in units of 1/(the object's radius), body frame, under a
    /// contact force, in N.
    pub(crate) fn slope(&self, force_b: &Vector2<f64>) -> Vector2<f64> {
        let (sin, cos) = sincos(self.direction);
        let direction = Vector2::new(cos, sin);
        self.share * tanh(direction.dot(force_b) / self.force) * direction
    }
}

#[cfg(test)]
mod tests {
    use super::Wobble;
    use nalgebra::Vector2;

    #[test]
    fn the_load_leans_with_the_push_and_not_across_it() {
        let wobble = Wobble { share: 0.4, ..Wobble::default() };
        assert!((wobble.slope(&Vector2::new(3.0, 0.0)).x - 0.4).abs() < 1e-8);
        assert!((wobble.slope(&Vector2::new(-3.0, 1.0)).x + 0.4).abs() < 1e-8);
        assert_eq!(wobble.slope(&Vector2::new(0.0, 2.0)), Vector2::zeros());
    }
}
