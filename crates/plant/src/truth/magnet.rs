//! A magnet under the table.

use libm::exp;
use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

/// A magnet below the table that pulls at a steel object.
///
/// At the distance d the object's parts feel pull·exp(−(d/reach)²) downward, which adds to their
/// load, and d/reach times that toward the magnet.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Magnet {
    /// Where it is, in m, world frame.
    pub place: [f64; 2],
    /// Downward pull on an object right above it, all of it there, in N.
    pub pull: f64,
    /// Distance at which the pull has fallen to 37 %, in m.
    pub reach: f64,
}

impl Default for Magnet {
    fn default() -> Self {
        Self { place: [0.0; 2], pull: 0.0, reach: 0.05 }
    }
}

impl Magnet {
    /// Downward and sideways pull (N, world frame) on the whole object if it were at a place (m).
    pub(crate) fn pulls(&self, place_w: &Vector2<f64>) -> (f64, Vector2<f64>) {
        let way = (Vector2::from(self.place) - place_w) / self.reach;
        let down = self.pull * exp(-way.dot(&way));
        (down, down * way)
    }
}

#[cfg(test)]
mod tests {
    use super::Magnet;
    use nalgebra::Vector2;

    #[test]
    fn a_magnet_pulls_down_and_toward_itself() {
        let magnet = Magnet { place: [0.1, 0.0], pull: 2.0, ..Magnet::default() };
        let (down, side) = magnet.pulls(&Vector2::new(0.05, 0.0));
        assert!((down - 2.0 * (-1.0_f64).exp()).abs() < 1e-12);
        assert!((side.x - down).abs() < 1e-12 && side.y == 0.0);
        assert_eq!(magnet.pulls(&Vector2::new(0.1, 0.0)), (2.0, Vector2::zeros()));
    }
}
