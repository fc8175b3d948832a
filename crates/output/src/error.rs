//! Why an output could not be written.

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

/// Why a file or folder could not be written; what was there before is as it was.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum OutputError {
    /// The operating system refused.
    #[error("cannot {action} {path}: {source}")]
    Io {
        /// What was tried: `write`, `read`, ...
        action: &'static str,
        /// The output, or a file that stands in for it until it is whole.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// A file of this name is there, and may not be replaced.
    #[error("cannot write {path}: it exists; remove it or name another file")]
    Exists {
        /// The file.
        path: PathBuf,
    },
    /// A folder of this name is there with files in it, and may not be replaced.
    #[error("cannot write {path}: the folder is not empty; choose a new one")]
    NotEmpty {
        /// The folder.
        path: PathBuf,
    },
    /// Another run has begun to write the same output.
    #[error("cannot write {path}: another run is writing it; wait for its end or name another")]
    Busy {
        /// The output.
        path: PathBuf,
    },
    /// The folder that is to hold the output is not there.
    #[error("cannot write {path}: there is no folder {folder}; make it first")]
    NoFolder {
        /// The output.
        path: PathBuf,
        /// The folder.
        folder: PathBuf,
    },
    /// The path is no place for this output.
    #[error("cannot write {path}: {what}")]
    Unfit {
        /// The output.
        path: PathBuf,
        /// Why not, and what to do.
        what: &'static str,
    },
    /// The output is an input, or lies in one.
    #[error("cannot write {path}: it belongs to the input {input}; name another output")]
    Input {
        /// The output.
        path: PathBuf,
        /// The input.
        input: PathBuf,
    },
}

impl OutputError {
    pub(crate) fn io(action: &'static str, path: &Path, source: io::Error) -> Self {
        Self::Io { action, path: path.into(), source }
    }
}
