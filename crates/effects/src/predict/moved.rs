//! A pose and a velocity go in, the pose after some time comes out.

use planar::{Pose, Twist};

/// A pose after moving with a constant velocity for some time.
pub(crate) fn moved(pose: &Pose, twist: &Twist, time: f64) -> Pose {
    Pose { position: pose.position + time * twist.linear, angle: pose.angle + time * twist.angular }
}
