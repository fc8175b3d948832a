//! Pushes of which the object's poses before and after are known alone.

use nalgebra::Vector2;
use planar::Pose;

/// A push of which the object's poses before and after are known, and the pusher's way; world frame.
#[derive(Clone, Debug, PartialEq)]
pub struct WholePush {
    /// Its number, by which other files name it.
    pub push: u32,
    /// Measuring session, where one is named.
    pub session: Option<String>,
    /// When the clock of its way shows 0, in s; 0 where it is not known.
    pub t: f64,
    /// Pose of the body frame B before the push.
    pub object_start: Pose,
    /// Pose of B after it.
    pub object_end: Pose,
    /// Times, in s, and places of the pusher's center, in m; empty if its way was not recorded.
    pub tip: Vec<(f64, Vector2<f64>)>,
    /// Times, in s, and force on the object, in N; empty where it was not measured.
    pub force: Vec<(f64, Vector2<f64>)>,
}

/// The pushes of a file that are about one object.
#[derive(Clone, Debug, PartialEq)]
pub struct WholePushes {
    /// What the table calls the recording: the column `recording`, or the file's name with shape and
    /// speed where there are columns for them.
    pub recording: String,
    /// The object's name, where the file has it.
    pub shape: Option<String>,
    /// The pushes, in the order of the file.
    pub pushes: Vec<WholePush>,
}

/// A file of end points, with those that lie beside it.
#[derive(Clone, Debug)]
pub struct EndPoints {
    /// SHA-256 over what was read.
    pub sha256: String,
    /// One entry an object or recording, in the order of their names.
    pub sets: Vec<WholePushes>,
}
