//! Log formats behind one trait.

use std::path::{Path, PathBuf};

use serde::Serialize;

use super::find::find_files;
use crate::input::limits::ReadLimits;
use crate::recording::Recording;
use crate::recording::settings::Streams;
use crate::recording::whole_push::EndPoints;
use crate::{
    error::DatasetError,
    remark::{Remark, StreamRole},
};

/// A way in which recordings are stored.
///
/// Those of this crate are in [`crate::all_formats`]; [`crate::RecordingSet::open_with_format`] reads a set
/// with one of a user's own, which needs `id`, `endings` and `read`.
pub trait LogFormat: Sync {
    /// The name used in `dataset.toml`.
    fn id(&self) -> &'static str;

    /// Endings of its files without the dot, which are no part of a recording's name; none where a
    /// recording is a folder, which [`LogFormat::find`] then has to know.
    fn endings(&self) -> &'static [&'static str] {
        &[]
    }

    /// The recordings below a folder, sorted by name; a recording given itself is returned alone.
    ///
    /// # Errors
    /// `Io` if the folder cannot be read, `NoRecordings` if it has none of this format.
    fn find(&self, dir: &Path) -> Result<Vec<PathBuf>, DatasetError> {
        find_files(dir, self.id(), self.endings())
    }

    /// As [`LogFormat::find`], where the manifest names the files that make a recording.
    ///
    /// # Errors
    /// As [`LogFormat::find`].
    fn find_streams(&self, dir: &Path, _streams: &Streams) -> Result<Vec<PathBuf>, DatasetError> {
        self.find(dir)
    }

    /// Reads one recording; what can be saved from a damaged one is returned with remarks.
    ///
    /// - `limits`: the most that reading may cost. A format for logs that nobody tampers with may
    ///   leave it out of account.
    ///
    /// # Errors
    /// An error with path and byte or line if a stream cannot be found or nothing of it read;
    /// `OverLimit` for a recording that needs more than the limits allow.
    fn read(
        &self,
        path: &Path,
        streams: &Streams,
        limits: &ReadLimits,
    ) -> Result<Recording, DatasetError>;

    /// The pushes of a recording that holds the object's poses before and after each of them alone;
    /// none of one that holds its motion.
    ///
    /// # Errors
    /// As [`LogFormat::read`].
    fn end_points(
        &self,
        _path: &Path,
        _limits: &ReadLimits,
    ) -> Result<Option<EndPoints>, DatasetError> {
        Ok(None)
    }

    /// What one recording contains, for people who set up a manifest.
    ///
    /// # Errors
    /// An error with path and byte or line if nothing of the recording can be read, `OverLimit` as
    /// in [`LogFormat::read`].
    fn inspect(&self, path: &Path, limits: &ReadLimits) -> Result<Inspection, DatasetError> {
        Ok(Inspection::of(&self.read(path, &Streams::default(), limits)?))
    }
}

impl Inspection {
    /// The streams of a recording that was read.
    #[must_use]
    pub fn of(recording: &Recording) -> Self {
        let Recording { robot, object, wrench, .. } = recording;
        let wrench = wrench.as_ref().map(|wrench| (StreamRole::Wrench, &wrench.source, &wrench.t));
        let poses = [
            (StreamRole::Robot, &robot.source, &robot.t),
            (StreamRole::Object, &object.source, &object.t),
        ];
        let streams = poses.into_iter().chain(wrench).map(|(role, source, t)| {
            let first = t.iter().copied().fold(f64::INFINITY, f64::min);
            let span = t.iter().copied().fold(f64::NEG_INFINITY, f64::max) - first;
            StreamInfo {
                name: if source.is_empty() { role.to_string() } else { source.clone() },
                count: t.len() as u64,
                rate_hz: (span > 0.0).then(|| (t.len() - 1) as f64 / span),
                fits: vec![role],
                ..StreamInfo::default()
            }
        });
        Self { streams: streams.collect(), remarks: recording.remarks.clone(), ..Self::default() }
    }
}

/// What a recording contains.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Inspection {
    /// Topics, files or data sets.
    pub streams: Vec<StreamInfo>,
    /// Fixed or moving frames published in the log, as (parent, child).
    pub frames: Vec<(String, String)>,
    /// What is wrong with the recording.
    pub remarks: Vec<Remark>,
}

/// One topic, file or data set of a recording.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct StreamInfo {
    /// Topic, file name or data set.
    pub name: String,
    /// Message type; empty where the format has none.
    pub type_name: String,
    /// Encoding of the messages; empty where the format has none.
    pub encoding: String,
    /// Columns of a table.
    pub columns: Vec<String>,
    /// Number of messages or rows.
    pub count: u64,
    /// Mean rate over the recording apart from its pauses, in Hz; none for fewer than two samples.
    pub rate_hz: Option<f64>,
    /// The streams that it could be, by its type.
    pub fits: Vec<StreamRole>,
}

/// What recordings of some format look like.
pub(crate) const ANY_FORMAT: &str = "MCAP, CSV folders, MIT JSON or HDF5, ROS 1 bags (features of this build), or end points as CSV";
