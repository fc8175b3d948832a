//! What a pusher's path does to an object.

use crate::ContactMode;
use planar::{Contact, Pose};

/// What a pusher's path does to an object.
#[derive(Clone, Debug, PartialEq)]
pub struct PathMotion {
    /// The object's pose at the end.
    pub pose_wb: Pose,
    /// The nearest point of the outline at the end, frame B.
    pub contact: Contact,
    /// The contact's history in order of its beginnings; empty if they never touch. Gaps in time are
    /// free motion; where the pusher presses on two walls of a notch, two phases overlap.
    pub phases: Vec<ContactPhase>,
    /// Time in contact, in s.
    pub contact_time: f64,
    /// Mean force along the inward normal over the time in contact, in N; 0 without contact, summed
    /// over the walls of a notch.
    pub mean_normal_force: f64,
    /// Mean force along the tangent (the normal turned by +90°), in N; 0 without contact.
    pub mean_tangential_force: f64,
    /// How far the pusher slid over the object, in m: positive along the tangent; of several contacts
    /// at the one that presses hardest.
    pub slip: f64,
    /// How deep the pusher overlapped the object when they touched first, in m.
    ///
    /// The object was moved out of it along the normal; 0 for a path that begins outside.
    pub overlap: f64,
    /// The object's poses at the start and at the end of each step.
    pub samples: Vec<PathSample>,
}

impl PathMotion {
    /// When the pusher first touched and last let go, in s.
    pub fn contact_span(&self) -> Option<(f64, f64)> {
        let end = self.phases.iter().map(|phase| phase.end).fold(f64::NEG_INFINITY, f64::max);
        Some((self.phases.first()?.start, end))
    }
}

/// What part of the outline the pusher touches, 0-based.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Place {
    /// Along an edge.
    Edge(usize),
    /// At a vertex; vertex i begins edge i.
    Vertex(usize),
}

/// A time span in which the contact keeps its mode and place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactPhase {
    /// Sticking or sliding.
    pub mode: ContactMode,
    /// The edge or vertex that is touched.
    pub place: Place,
    /// When it begins, in s.
    pub start: f64,
    /// When it ends, in s.
    pub end: f64,
}

/// Where the object is at the end of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathSample {
    /// Time on the pusher's path, in s.
    pub time: f64,
    /// The object's pose.
    pub pose_wb: Pose,
    /// Whether the pusher touches.
    pub touching: bool,
}

/// How finely a push is integrated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathSettings {
    /// Error allowed in a step, in m; an angle counts times the characteristic length.
    pub tolerance: f64,
    /// Longest travel of the pusher in a step, in m: samples are no further apart while they touch.
    pub max_travel: f64,
}

impl Default for PathSettings {
    /// 10 nm in a step of at most 5 mm.
    fn default() -> Self {
        Self { tolerance: 1e-8, max_travel: 5e-3 }
    }
}
