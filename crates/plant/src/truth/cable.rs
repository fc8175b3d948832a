//! A cable that pulls at the object.

use libm::sqrt;
use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

/// A cable from a point of the object to an anchor over the table.
///
/// It pulls toward the anchor with tension + stiffness·(distance of the anchor from the origin of
/// the table) as the object moves away from it; it never pushes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Cable {
    /// Where it is fixed to the object, in m, body frame.
    pub attachment: [f64; 2],
    /// Where it comes from, in m, world frame.
    pub anchor: [f64; 2],
    /// Pull while the attachment is as far from the anchor as the table's origin, in N.
    pub tension: f64,
    /// Rise of the pull with the distance, in N/m.
    pub stiffness: f64,
}

impl Cable {
    /// Whether there is no cable.
    pub(crate) fn is_off(&self) -> bool {
        self.tension == 0.0 && self.stiffness == 0.0
    }

    /// Force on the object, in N, world frame, with the attachment at a place of the world.
    pub(crate) fn pull(&self, attachment_w: &Vector2<f64>) -> Vector2<f64> {
        let anchor = Vector2::from(self.anchor);
        let way = anchor - attachment_w;
        let distance = sqrt(way.dot(&way));
        if distance == 0.0 {
            return Vector2::zeros();
        }
        let stretch = distance - sqrt(anchor.dot(&anchor));
        (self.tension + self.stiffness * stretch).max(0.0) / distance * way
    }
}

#[cfg(test)]
mod tests {
    use super::Cable;
    use nalgebra::Vector2;

    #[test]
    fn a_cable_pulls_toward_its_anchor_and_harder_from_afar_but_never_pushes() {
        let cable = Cable { anchor: [0.0, 1.0], tension: 0.3, stiffness: 2.0, ..Cable::default() };
        assert_eq!(cable.pull(&Vector2::zeros()), Vector2::new(0.0, 0.3));
        assert!((cable.pull(&Vector2::new(0.0, -0.1)).y - 0.5).abs() < 1e-15);
        assert_eq!(cable.pull(&Vector2::new(0.0, 0.5)), Vector2::zeros());
    }
}
