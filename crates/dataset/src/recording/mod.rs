//! One recording, as all formats give it: the streams of a log exactly as they were recorded.

pub(crate) mod frames;
pub(crate) mod lateness;
pub(crate) mod name;
pub(crate) mod settings;
pub(crate) mod transform;
pub(crate) mod whole_push;

use std::path::{Path, PathBuf};

use crate::input::limits::ReadLimits;
use crate::input::map::FileBytes;
use crate::{error::DatasetError, remark::Remark};

/// The streams of one log file or folder, in SI units and in the world frame.
///
/// Order, duplicates and gaps are as recorded: repairs belong to the ingest. Only rows that hold
/// no usable value are missing, and each such loss is one of the `remarks`.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// Name of the recording, as [`crate::recording_name`] gives it.
    pub name: String,
    /// Where it was read from.
    pub path: PathBuf,
    /// SHA-256 of the source's bytes, in lower-case hexadecimal digits.
    pub sha256: String,
    /// Zero of the streams' times: the earliest stamp, rounded down to a whole second, in ns
    /// since the clock's own zero.
    pub epoch_ns: i64,
    /// Poses of the pusher's center.
    pub robot: PoseStream,
    /// Poses of the tracked body frame B.
    pub object: PoseStream,
    /// Forces on the pusher, where they were recorded.
    pub wrench: Option<WrenchStream>,
    /// What reading had to replace, skip or warn about.
    pub remarks: Vec<Remark>,
}

impl Recording {
    /// Streams that were made, not read: a recording without a source, to be written.
    ///
    /// - `epoch`: zero of the streams' times since the clock's own zero, in s.
    #[must_use]
    pub fn made(
        name: String,
        epoch: i64,
        robot: PoseStream,
        object: PoseStream,
        wrench: Option<WrenchStream>,
    ) -> Self {
        Self {
            name,
            path: PathBuf::new(),
            sha256: String::new(),
            epoch_ns: epoch.saturating_mul(1_000_000_000),
            robot,
            object,
            wrench,
            remarks: Vec::new(),
        }
    }

    /// The same recording as read from a file, whose SHA-256 it gets.
    ///
    /// # Errors
    /// `Io` if the file cannot be read, `NotAFile` if it is none.
    pub fn with_source(self, path: &Path) -> Result<Self, DatasetError> {
        let sha256 = FileBytes::open(path, &ReadLimits::default())?.sha256();
        Ok(Self { path: path.to_path_buf(), sha256, ..self })
    }
}

/// Poses over time in the world frame W.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PoseStream {
    /// Topic, file or data set that the poses come from.
    pub source: String,
    /// Times since [`Recording::epoch_ns`], in s.
    pub t: Vec<f64>,
    /// Positions along x, in m.
    pub x: Vec<f64>,
    /// Positions along y, in m.
    pub y: Vec<f64>,
    /// Yaw, counter-clockwise positive, as recorded (not unwrapped), in rad.
    pub theta: Vec<f64>,
    /// Largest angle between the body's z axis and the world's, in rad.
    pub max_tilt: f64,
}

impl PoseStream {
    /// Appends a pose: time in s, position in m, yaw in rad.
    pub fn push(&mut self, t: f64, x: f64, y: f64, theta: f64) {
        self.t.push(t);
        self.x.push(x);
        self.y.push(y);
        self.theta.push(theta);
    }

    /// Number of poses.
    #[must_use]
    pub fn len(&self) -> usize {
        self.t.len()
    }

    /// Whether there is no pose.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.t.is_empty()
    }
}

/// Forces of the object on the pusher over time, in the world frame W.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WrenchStream {
    /// Topic, file or data set that the forces come from.
    pub source: String,
    /// Times since [`Recording::epoch_ns`], in s.
    pub t: Vec<f64>,
    /// Forces along x, in N.
    pub fx: Vec<f64>,
    /// Forces along y, in N.
    pub fy: Vec<f64>,
    /// Torques about z, in N·m; empty if the log has none.
    pub tz: Vec<f64>,
}

impl WrenchStream {
    /// Appends a force without torque: time in s, force of the object on the pusher in N.
    pub fn push(&mut self, t: f64, fx: f64, fy: f64) {
        self.t.push(t);
        self.fx.push(fx);
        self.fy.push(fy);
    }

    /// Number of samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.t.len()
    }

    /// Whether there is no sample.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.t.is_empty()
    }
}
