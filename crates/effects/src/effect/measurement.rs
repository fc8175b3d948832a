//! How measured streams differ from what they measure.

use nalgebra::Vector2;
use planar::Pose;

/// Gathered errors of the measured streams: effects add to it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeasurementModel {
    /// Place of the true outline in the tracked frame B, in m.
    pub offset_b: Vector2<f64>,
    /// Turn of the true outline against B, in rad.
    pub yaw: f64,
    /// Place of the pusher beside where the robot tells it, in m, axes of W; what depends on a place of the table is
    /// asked for in the robot's frame.
    pub robot_w: Vector2<f64>,
    /// How late the object's stream is against the robot's, in s.
    pub latency: f64,
    /// What the force sensor adds to the force on the object, in N, axes of W.
    pub force_bias_w: Vector2<f64>,
    /// How far the sensor turns the force, in rad.
    pub force_turn: f64,
}

impl MeasurementModel {
    /// The true outline's frame in the tracked frame.
    pub(crate) fn pose_bo(&self) -> Pose {
        Pose { position: self.offset_b, angle: self.yaw }
    }

    /// A pose that motion capture shows, in the robot's frame.
    pub(crate) fn in_robot(&self, pose: &Pose) -> Pose {
        Pose { position: pose.position - self.robot_w, ..*pose }
    }

    /// A pose in the robot's frame as motion capture shows it.
    pub(crate) fn in_cameras(&self, pose: &Pose) -> Pose {
        Pose { position: pose.position + self.robot_w, ..*pose }
    }

    /// What the sensor shows of a force, in N, axes of W.
    pub(crate) fn force(&self, force_w: &Vector2<f64>) -> Vector2<f64> {
        Pose::new(0.0, 0.0, self.force_turn).rotate(force_w) + self.force_bias_w
    }
}
