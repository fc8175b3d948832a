//! Small recordings, written in every format by the project's own writers.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use dataset::{PoseStream, Recording, WrenchStream, all_writers};

use super::super::reader::not_finite;

/// A push of a square of 90 mm along x that lasts this many samples of each stream at 50 Hz.
pub(super) fn push(n_samples: usize) -> Recording {
    let (mut robot, mut object) = (PoseStream::default(), PoseStream::default());
    let mut wrench = WrenchStream::default();
    for k in 0..n_samples {
        let t = 0.02 * k as f64;
        // The pusher is in contact from the start of the second half on.
        let way = 0.02 * (t - 0.01 * n_samples as f64).max(0.0);
        robot.push(t, -0.055 + 0.02 * t.min(0.01 * n_samples as f64) + way, 0.01, 0.0);
        object.push(t + 0.003, way, 0.0, -0.5 * way);
        wrench.push(t + 0.001, if way > 0.0 { -2.0 } else { 0.01 }, 0.0);
    }
    Recording::made("push".to_owned(), 1_700_000_000, robot, object, Some(wrench))
}

/// Writes a recording below a folder.
pub(super) fn write(writer: &str, recording: &Recording, dir: &Path) -> Result<PathBuf> {
    let known = all_writers().iter().find(|known| known.id() == writer);
    Ok(known.with_context(|| format!("no writer {writer}"))?.write(recording, dir)?)
}

/// The bytes of a recording that is one file.
pub(super) fn written(writer: &str, recording: &Recording, dir: &Path) -> Result<Vec<u8>> {
    Ok(fs::read(write(writer, recording, &dir.join(writer))?)?)
}

/// What is wrong with a recording that was read.
pub(super) fn wrong(recording: &Recording) -> Option<String> {
    let Recording { robot, object, wrench, .. } = recording;
    for (name, stream) in [("robot", robot), ("object", object)] {
        let PoseStream { t, x, y, theta, max_tilt, .. } = stream;
        let lengths = [x.len(), y.len(), theta.len()];
        if lengths.iter().any(|length| *length != t.len()) {
            return Some(format!("{name} is of lengths {} and {lengths:?}", t.len()));
        }
        let numbers = [("t", &t[..]), ("x", x), ("y", y), ("theta", theta)];
        let tilt = [("tilt", std::slice::from_ref(max_tilt))];
        if let Some(wrong) = not_finite(numbers.into_iter().chain(tilt)) {
            return Some(format!("{name} {wrong}"));
        }
    }
    let WrenchStream { t, fx, fy, tz, .. } = wrench.as_ref()?;
    if fx.len() != t.len() || fy.len() != t.len() || (!tz.is_empty() && tz.len() != t.len()) {
        return Some("wrench is of different lengths".to_owned());
    }
    let wrong = not_finite([("t", &t[..]), ("fx", fx), ("fy", fy), ("tz", tz)])?;
    Some(format!("wrench {wrong}"))
}
