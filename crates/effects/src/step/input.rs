//! One step of a push, as numbers in SI units.

use std::sync::Arc;

use nalgebra::Vector2;
use planar::{Pose, Twist};

use crate::error::{finite, not_negative};
use crate::{EffectError, Object, RunUp, Track};

/// What is known of a step before its outcome: what an effect and a prediction may depend on.
///
/// Frames: W is the table, B the tracked body frame, nominally that of the outline. Each field has
/// its source in a row of the step table:
///
/// | field | columns |
/// |---|---|
/// | `object`, `pusher_radius` | `shape` and the set's manifest |
/// | `pose_wb`, `twist_wb` | `object_x_m` … `object_omega_rad_s` |
/// | `track` | [`Track::accelerated`] of `pusher_x0_m` … `pusher_ay_m_s2` and `dt_s` |
/// | `touching` | `phase` is contact, and no flag says that contact was lost |
/// | `since_contact` | `since_contact_s` |
/// | `run_up` | the rows of the push |
/// | `progress`, `session` | the order of `t_s` in the set, `session` |
#[derive(Clone, Debug)]
pub struct StepInput {
    /// What is pushed.
    pub object: Arc<Object>,
    /// Nominal radius of the pusher, in m.
    pub pusher_radius: f64,
    /// Measured pose of B in W at the start.
    pub pose_wb: Pose,
    /// Measured velocity of B's origin, in m/s, and yaw rate, in rad/s, at the start, axes of W.
    pub twist_wb: Twist,
    /// The pusher's measured way over the step, frame W.
    pub track: Track,
    /// Whether the pusher is known to touch the object at the start.
    ///
    /// If so the measured gap is an error of measurement: the object is set against the pusher. If
    /// not, it rests until the way over the step meets it: a whole push may be one step.
    pub touching: bool,
    /// Time from the push's first contact to the start, in s; 0 where contact begins.
    pub since_contact: f64,
    /// The push before the start, in which the pusher is taken to touch from the first contact on. With it an object
    /// with inertia that is touched begins as fast as the model makes it from rest there; without it, with `twist_wb`.
    pub run_up: Option<Arc<RunUp>>,
    /// Place of the push in the order of the set: 0 for the first, 1 for the last.
    pub progress: f64,
    /// 0-based measuring session; 0 where sessions are not known.
    pub session: u32,
}

/// Mean speed below which the pusher has no direction, in m/s.
const REST: f64 = 1e-4;

impl StepInput {
    /// The direction of Δx, a unit vector in W: of the pusher's mean velocity, or, while it rests
    /// (below 0.1 mm/s), of the contact normal at the start.
    pub fn direction_w(&self) -> Vector2<f64> {
        let velocity = self.track.mean_velocity();
        let speed = velocity.norm();
        if speed >= REST {
            return velocity / speed;
        }
        let center = self.pose_wb.inverse_transform_point(&self.track.start());
        let contact = self.object.shape().contact(&center, self.pusher_radius);
        self.pose_wb.rotate(&contact.normal)
    }

    /// Refuses numbers that no step can have.
    pub(crate) fn validate(&self) -> Result<(), EffectError> {
        not_negative("the pusher's radius", self.pusher_radius, "m")?;
        let Pose { position, angle } = &self.pose_wb;
        finite("the start pose", position.x + position.y + angle, "m or rad")?;
        let Twist { linear, angular } = &self.twist_wb;
        finite("the start velocity", linear.x + linear.y + angular, "m/s or rad/s")?;
        not_negative("the time since contact", self.since_contact, "s")?;
        finite("the push's place in the set", self.progress, "(share of the set)")?;
        if !self.track.is_usable() {
            let (name, expected) = ("the track's duration", "at least 1e-200, with finite places");
            let value = self.track.duration();
            return Err(EffectError::InvalidValue { name, expected, value, unit: "s" });
        }
        Ok(())
    }
}
