//! Writers of recordings behind one trait.

use std::{
    fs,
    path::{Path, PathBuf},
};

use crate::error::DatasetError;
use crate::recording::Recording;

/// A way to write recordings that the format of the same kind reads back.
///
/// Numbers are rounded to 1 µs, 1 µm, 1 µrad, 1 mN and 1 µN·m, so that the same recording gives
/// the same bytes on every machine. A yaw that is written as a quaternion comes back within (−π, π].
pub trait RecordingWriter: Sync {
    /// Name of the writer: `csv`, `mcap-ros2`, ...
    fn id(&self) -> &'static str;

    /// Name of the format that reads what it writes, as in `dataset.toml`.
    fn format(&self) -> &'static str;

    /// Writes a recording below a folder under its own name, and returns where.
    ///
    /// # Errors
    /// `Unwritable` if a stream has a value that is not finite or columns of different lengths,
    /// `Io` or `Output` if the file system refuses.
    fn write(&self, recording: &Recording, dir: &Path) -> Result<PathBuf, DatasetError>;
}

/// Creates a folder with its parents.
pub(crate) fn make_dir(dir: &Path) -> Result<(), DatasetError> {
    fs::create_dir_all(dir).map_err(|error| DatasetError::io("create", dir, error))
}
