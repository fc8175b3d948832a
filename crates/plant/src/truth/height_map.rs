//! Height over the table.

use libm::{exp, sincos};
use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

use super::Texture;

/// The table's departures from a level plane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct HeightMap {
    /// Part of gravity along the tilted table, in m/s², world frame: it points downhill.
    pub downhill: [f64; 2],
    /// A groove worn by earlier pushes.
    pub groove: Groove,
    /// Height of its bumps, in m, felt where the underside has a stiffness.
    pub texture: Texture,
}

/// A straight groove with smooth walls, depth·exp(−(distance/width)²).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Groove {
    /// A point of its bottom line, in m, world frame.
    pub point: [f64; 2],
    /// Direction of its bottom line, in rad, world frame.
    pub direction: f64,
    /// Depth, in m.
    pub depth: f64,
    /// Half width, in m.
    pub width: f64,
    /// Share of the friction that polish took away at the bottom.
    pub polish: f64,
}

impl Default for Groove {
    fn default() -> Self {
        Self { point: [0.0; 2], direction: 0.0, depth: 0.0, width: 0.004, polish: 0.0 }
    }
}

impl Groove {
    /// Whether there is no groove.
    pub(crate) fn is_off(&self) -> bool {
        self.depth == 0.0 && self.polish == 0.0
    }

    /// Slope of the table (rise per way, world frame) and factor on the friction at a place (m).
    pub(crate) fn at(&self, place_w: &Vector2<f64>) -> (Vector2<f64>, f64) {
        let (sin, cos) = sincos(self.direction);
        let across = Vector2::new(-sin, cos);
        let offset = across.dot(&(place_w - Vector2::from(self.point))) / self.width;
        let bell = exp(-offset * offset);
        (2.0 * self.depth * offset * bell / self.width * across, 1.0 - self.polish * bell)
    }
}

#[cfg(test)]
mod tests {
    use super::Groove;
    use nalgebra::Vector2;

    #[test]
    fn the_walls_rise_away_from_the_bottom_and_the_slope_is_that_of_the_height() {
        let groove = Groove { direction: 0.4, depth: 3e-4, polish: 0.25, ..Groove::default() };
        let height = |place: &Vector2<f64>| {
            let across = place.dot(&Vector2::new(-0.4_f64.sin(), 0.4_f64.cos()));
            -3e-4 * (-(across / 0.004).powi(2)).exp()
        };
        let place = Vector2::new(0.001, 0.003);
        let (slope, factor) = groove.at(&place);
        for axis in 0..2 {
            let mut step = Vector2::zeros();
            step[axis] = 1e-7;
            let expected = (height(&(place + step)) - height(&(place - step))) / 2e-7;
            assert!((slope[axis] - expected).abs() < 1e-8);
        }
        assert!(factor > 0.75 && factor < 1.0);
        assert_eq!(groove.at(&Vector2::zeros()).1, 0.75);
    }
}
