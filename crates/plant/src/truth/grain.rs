//! Friction that depends on the direction of motion.

use libm::{sincos, sqrt};
use nalgebra::Matrix2;
use serde::{Deserialize, Serialize};

/// A grain along which friction differs from friction across it.
///
/// A load N that moves with v dissipates μN √(vᵀGv), G having the eigenvalue `ratio` along the
/// grain and 1/`ratio` across it: friction is √ratio·μ along and μ/√ratio across, and between them
/// it does not quite point against the motion.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Grain {
    /// Friction along the grain over friction across it.
    pub ratio: f64,
    /// Direction of the grain, in rad, in the frame of its table or object.
    pub direction: f64,
}

impl Default for Grain {
    fn default() -> Self {
        Self { ratio: 1.0, direction: 0.0 }
    }
}

impl Grain {
    /// √G, with the grain's frame turned by `turn` (rad); the unit matrix without a grain.
    pub(crate) fn root_metric(&self, turn: f64) -> Matrix2<f64> {
        if self.ratio == 1.0 {
            return Matrix2::identity();
        }
        let (sin, cos) = sincos(self.direction + turn);
        let along = sqrt(self.ratio);
        let across = 1.0 / along;
        let off = (along - across) * sin * cos;
        Matrix2::new(
            along * cos * cos + across * sin * sin,
            off,
            off,
            along * sin * sin + across * cos * cos,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::Grain;
    use nalgebra::{Matrix2, Vector2};

    #[test]
    fn friction_along_the_grain_is_ratio_times_friction_across_it() {
        let grain = Grain { ratio: 1.5, direction: 0.3 };
        let root = grain.root_metric(0.2);
        let along = Vector2::new(0.5_f64.cos(), 0.5_f64.sin());
        let across = Vector2::new(-along.y, along.x);
        let friction = |v: &Vector2<f64>| (root * v).norm();
        assert!((friction(&along) / friction(&across) - 1.5).abs() < 1e-14);
        assert!((friction(&along) * friction(&across) - 1.0).abs() < 1e-14);
        assert_eq!(Grain::default().root_metric(0.4), Matrix2::identity());
    }
}
