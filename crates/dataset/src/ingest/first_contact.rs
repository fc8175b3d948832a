//! Where and how a push first touches, recovered from the poses.

use planar::{Pose, wrap_angle};
use serde::{Deserialize, Serialize};

use crate::ingest::push::Push;
use crate::ingest::scene::Scene;
use crate::ingest::settings::{IngestSettings, StepLength};

/// Where and how a push first touches.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FirstContact {
    /// Edge.
    pub edge: u32,
    /// Position along it.
    pub p: f64,
    /// Contact point in the body frame.
    pub point_b_m: [f64; 2],
    /// Angle from the edge's inward normal to the pusher's mean velocity over the first step.
    pub beta_rad: f64,
    /// Speed of the pusher over the first step.
    pub speed_m_s: f64,
}

impl FirstContact {
    /// The first contact of a push; none if the robot's stream or all object poses are missing.
    pub(crate) fn of(scene: &Scene<'_>, push: &Push, settings: &IngestSettings) -> Option<Self> {
        let from = push.begins;
        let length = match settings.step {
            StepLength::Time(length) => length,
            StepLength::Distance(_) => f64::INFINITY,
        };
        let to = (from + length).min(push.contact_end());
        let (start, end) = (scene.robot_track.position(from)?, scene.robot_track.position(to)?);
        let pose = resting_pose(scene, from)?;
        let shape = scene.outline.shape;
        let contact =
            shape.contact(&pose.inverse_transform_point(&start), scene.outline.pusher_radius);
        let velocity = (end - start) / (to - from);
        let normal = pose.rotate(&shape.inward_normal_at(contact.edge, contact.p));
        Some(Self {
            edge: contact.edge as u32,
            p: contact.p,
            point_b_m: contact.point.into(),
            beta_rad: wrap_angle(velocity.y.atan2(velocity.x) - normal.y.atan2(normal.x)),
            speed_m_s: velocity.norm(),
        })
    }
}

/// The object's pose as the push begins; in a gap the last one before, for the object still rests.
fn resting_pose(scene: &Scene<'_>, t: f64) -> Option<Pose> {
    scene.object_track.pose(t).or_else(|| {
        let object = &scene.object;
        let last = object.t.partition_point(|&stamp| stamp <= t).checked_sub(1)?;
        let [x, y, angle] = [0, 1, 2].map(|channel| object.channels[channel][last]);
        Some(Pose::new(x, y, angle))
    })
}
