//! How exactly the nominal values of a set are known.

use effects::{EffectInfo, Nuisance, Tolerance};
use serde::{Deserialize, Serialize};

/// Standard errors of what a set's manifest and its streams claim; SI units.
///
/// They are nuisances of every test: what they could explain is no evidence for anything else.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Tolerances {
    /// Of the pusher's radius, in m.
    pub pusher_radius: f64,
    /// Of the tracked frame's place in the outline, along each axis, in m.
    pub pose: f64,
    /// Of the tracked frame's turn, in rad.
    pub yaw: f64,
    /// Of the time between the streams, in s.
    pub latency: f64,
    /// Size of the contact's own compliance, in m/N.
    pub compliance: f64,
}

impl Default for Tolerances {
    /// 0.1 mm, 0.1 mm, 0.2°, 2 ms, 2e-5 m/N.
    fn default() -> Self {
        Self {
            pusher_radius: 1e-4,
            pose: 1e-4,
            yaw: 0.2_f64.to_radians(),
            latency: 2e-3,
            compliance: 2e-5,
        }
    }
}

impl Tolerances {
    /// The standard error of an effect's coordinates where the effect is a nuisance; infinite where
    /// nothing is known of it beforehand.
    pub(crate) fn of(&self, about: &EffectInfo) -> Option<f64> {
        match about.nuisance {
            Nuisance::No => None,
            Nuisance::Free { .. } => Some(f64::INFINITY),
            Nuisance::Known(tolerance) => Some(self.sd(tolerance)),
        }
    }

    fn sd(&self, tolerance: Tolerance) -> f64 {
        match tolerance {
            Tolerance::PusherRadius => self.pusher_radius,
            Tolerance::Pose => self.pose,
            Tolerance::Yaw => self.yaw,
            Tolerance::Latency => self.latency,
            Tolerance::Compliance => self.compliance,
        }
    }
}
