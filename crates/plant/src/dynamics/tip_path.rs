//! The path of the robot's hand, which holds the tip.

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

/// A straight way at a speed, with a limited acceleration, after a wait and before a hold.
///
/// A way too short for the speed is gone with acceleration and deceleration alone.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TipPath {
    /// Where the unloaded tip's center starts, in m, world frame.
    pub start: [f64; 2],
    /// Unit direction, world frame.
    pub direction: [f64; 2],
    /// Length of the way, in m.
    pub length: f64,
    /// Speed, in m/s.
    pub speed: f64,
    /// Acceleration at the start and deceleration at the end, in m/s².
    pub acceleration: f64,
    /// Time at rest before the way, in s.
    pub wait: f64,
    /// Time at rest after the way, in s.
    pub hold: f64,
}

impl TipPath {
    /// Times at which the acceleration jumps, and the end, in s, in order.
    #[must_use]
    pub fn breaks(&self) -> [f64; 5] {
        let (ramp, cruise) = self.ramp_and_cruise();
        let start = self.wait;
        [
            start,
            start + ramp,
            start + ramp + cruise,
            start + ramp + cruise + ramp,
            start + ramp + cruise + ramp + self.hold,
        ]
    }

    /// How long it takes, in s.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.breaks()[4]
    }

    /// Where the unloaded tip's center is at a time (s), in m, world frame.
    #[must_use]
    pub fn position(&self, time: f64) -> Vector2<f64> {
        Vector2::from(self.start) + self.way(time) * Vector2::from(self.direction)
    }

    /// Way gone at a time, in m.
    fn way(&self, time: f64) -> f64 {
        let (ramp, cruise) = self.ramp_and_cruise();
        let t = time - self.wait;
        let ramp_way = 0.5 * self.acceleration * ramp * ramp;
        if t <= 0.0 {
            0.0
        } else if t < ramp {
            0.5 * self.acceleration * t * t
        } else if t < ramp + cruise {
            ramp_way + self.acceleration * ramp * (t - ramp)
        } else {
            let left = (ramp + cruise + ramp - t).max(0.0);
            self.length - 0.5 * self.acceleration * left * left
        }
    }

    fn ramp_and_cruise(&self) -> (f64, f64) {
        let ramp = self.speed / self.acceleration;
        let cruise = self.length / self.speed - ramp;
        if cruise >= 0.0 { (ramp, cruise) } else { ((self.length / self.acceleration).sqrt(), 0.0) }
    }
}

#[cfg(test)]
mod tests {
    use super::TipPath;
    use nalgebra::Vector2;

    fn path(length: f64) -> TipPath {
        TipPath {
            start: [0.1, 0.0],
            direction: [0.6, 0.8],
            length,
            speed: 0.2,
            acceleration: 2.0,
            wait: 0.1,
            hold: 0.3,
        }
    }

    #[test]
    fn the_way_is_gone_at_the_speed_within_the_acceleration() {
        for length in [0.05, 0.01] {
            let path = path(length);
            let end = Vector2::new(0.1, 0.0) + length * Vector2::new(0.6, 0.8);
            assert_eq!(path.position(0.1), Vector2::new(0.1, 0.0));
            assert!((path.position(path.duration()) - end).norm() < 1e-15);
            let step = 1e-4;
            let velocity = |t: f64| (path.position(t + step) - path.position(t)).norm() / step;
            let mut t = 0.0;
            while t < path.duration() {
                assert!(velocity(t) <= 0.2 + 1e-9);
                assert!((velocity(t + step) - velocity(t)).abs() / step < 2.0 + 1e-6);
                t += step;
            }
        }
        assert!((path(0.05).duration() - (0.1 + 0.1 + 0.15 + 0.1 + 0.3)).abs() < 1e-12);
    }
}
