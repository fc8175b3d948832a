//! One row of the table: a step of a push with all that models and diagnosis need.

use std::{fmt, str::FromStr, sync::Arc};

use nalgebra::Vector2;
use planar::{Pose, Twist};

use crate::table::flags::Flags;

/// A time step of one push, in SI units.
///
/// Frames: W world, B the tracked body frame. Δx and Δy are the displacement of B's origin along
/// the pusher's mean velocity over the step and along its left normal; angles are counter-clockwise
/// positive. Forces act **on the object**. While the pusher rests, its direction is not defined:
/// the contact normal stands in for it, β is 0, and the row is flagged `pusher_at_rest`.
#[derive(Clone, Debug, PartialEq)]
pub struct StepRow {
    /// Name of the recording.
    pub recording: Arc<str>,
    /// Measuring session, where `sessions.csv` names one.
    pub session: Option<Arc<str>>,
    /// 0-based number of the push within its recording.
    pub push: u32,
    /// 0-based number of the step within its push.
    pub step: u32,
    /// Whether the pusher touches the object.
    pub phase: Phase,
    /// Start of the step on the log's clock (where that is Unix time, since 1970), in s.
    pub t: f64,
    /// Length of the step, in s.
    pub dt: f64,
    /// Number of object samples within the step.
    pub n_samples: u32,
    /// Name of the object's shape.
    pub shape: Arc<str>,
    /// Edge touched at the start: i runs from vertex i to i + 1, counter-clockwise.
    pub edge: u32,
    /// Position of the contact along the edge at the start, 0 to 1.
    pub p: f64,
    /// Angle from the inward normal to the pusher's mean velocity, in rad. Where a vertex is
    /// touched the normal is that of `edge`, and `contact_normal` stands beside it.
    pub beta: f64,
    /// Speed of the pusher: its mean velocity's magnitude, in m/s.
    pub speed: f64,
    /// Pose of B in W at the start.
    pub object_pose: Pose,
    /// Velocity of B's origin and yaw rate at the start, in W.
    pub object_twist: Twist,
    /// Pusher's center in W at the start, in m.
    pub pusher_start: Vector2<f64>,
    /// Pusher's center in W at the end, in m.
    pub pusher_end: Vector2<f64>,
    /// Where the pusher's center is between start and end of a whole push: times from the start, in s,
    /// and places in W, in m, with straight ways at constant speed from one to the next. None where
    /// the mean acceleration says enough.
    pub pusher_way: Vec<(f64, Vector2<f64>)>,
    /// Mean velocity of the pusher in W, in m/s.
    pub pusher_velocity: Vector2<f64>,
    /// Mean acceleration of the pusher in W, 4 (r₀ − 2 r½ + r₁)/dt², in m/s².
    pub pusher_acceleration: Vector2<f64>,
    /// Signed curvature of the pusher's path, (v × a)/|v|³, left turns positive, in 1/m.
    pub path_curvature: f64,
    /// Contact point in W at the start, in m.
    pub contact_point: Vector2<f64>,
    /// Contact normal in W at the start, into the object.
    pub contact_normal: Vector2<f64>,
    /// Displacement of B along the pusher's mean velocity, in m.
    pub dx: f64,
    /// Displacement of B along the left normal of the pusher's mean velocity, in m.
    pub dy: f64,
    /// Turn of the object, in rad.
    pub dtheta: f64,
    /// Contact force, where it was measured over the step.
    pub force: Option<StepForce>,
    /// Distance between the pusher's surface and the outline at the start, in m.
    pub gap_start: f64,
    /// Distance between the pusher's surface and the outline at the end, in m.
    pub gap_end: f64,
    /// Way of the contact point along the outline (rolling included), towards larger p, in m.
    pub slip: f64,
    /// Time from the first contact to the start, in s.
    pub since_contact: f64,
    /// Standard deviation of the start position, per axis, from the samples' noise, in m.
    pub start_position_sd: f64,
    /// Standard deviation of the start yaw from the samples' noise, in rad.
    pub start_angle_sd: f64,
    /// Standard deviation of the end position, per axis, from the samples' noise, in m.
    pub end_position_sd: f64,
    /// Standard deviation of the end yaw from the samples' noise, in rad.
    pub end_angle_sd: f64,
    /// What is special about this row.
    pub flags: Flags,
}

impl StepRow {
    /// Whether the step is a whole push, of which the object's ends alone are known.
    #[must_use]
    pub fn is_whole_push(&self) -> bool {
        self.flags.contains(Flags::WHOLE_PUSH)
    }
}

/// Force on the object over one step, normal and tangential to the contact, in N.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepForce {
    /// Mean over the step.
    pub mean: ContactForce,
    /// At the start.
    pub start: ContactForce,
    /// At the end.
    pub end: ContactForce,
}

/// A force on the object in the contact frame, in N.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactForce {
    /// Along the inward normal, positive when the pusher presses.
    pub normal: f64,
    /// Along the inward normal turned by +90°, the way of decreasing p.
    pub tangential: f64,
}

/// Where in a push a step lies.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize,
)]
#[serde(rename_all = "snake_case")]
pub enum Phase {
    /// From first to last contact.
    #[default]
    Contact,
    /// From the last contact until the object rests.
    After,
}

impl fmt::Display for Phase {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Contact => "contact",
            Self::After => "after",
        })
    }
}

impl FromStr for Phase {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "contact" => Ok(Self::Contact),
            "after" => Ok(Self::After),
            _ => Err("contact or after".into()),
        }
    }
}

impl Default for StepRow {
    /// A step of 1 s in which nothing moves: zeros, identity pose, no force and no flags.
    fn default() -> Self {
        let (zero, origin) = (Vector2::zeros(), Pose::new(0.0, 0.0, 0.0));
        Self {
            recording: Arc::from(""),
            session: None,
            push: 0,
            step: 0,
            phase: Phase::Contact,
            t: 0.0,
            dt: 1.0,
            n_samples: 0,
            shape: Arc::from(""),
            edge: 0,
            p: 0.0,
            beta: 0.0,
            speed: 0.0,
            object_pose: origin,
            object_twist: Twist { linear: zero, angular: 0.0 },
            pusher_start: zero,
            pusher_end: zero,
            pusher_way: Vec::new(),
            pusher_velocity: zero,
            pusher_acceleration: zero,
            path_curvature: 0.0,
            contact_point: zero,
            contact_normal: Vector2::x(),
            dx: 0.0,
            dy: 0.0,
            dtheta: 0.0,
            force: None,
            gap_start: 0.0,
            gap_end: 0.0,
            slip: 0.0,
            since_contact: 0.0,
            start_position_sd: 0.0,
            start_angle_sd: 0.0,
            end_position_sd: 0.0,
            end_angle_sd: 0.0,
            flags: Flags::default(),
        }
    }
}
