//! One run at a time writes an output.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use same_file::Handle;

use crate::error::OutputError;
use crate::place::Place;

/// The right to write an output, told to other runs by a locked file `.NAME.lock` beside it.
///
/// The system gives the lock back when a run is killed; the file stays, and tells the next run of
/// the same output that there may be leftovers.
#[derive(Debug)]
pub(crate) struct Lock {
    path: PathBuf,
    /// Open while the lock is held.
    _file: File,
}

impl Lock {
    /// Takes the lock, and removes what a killed run left.
    ///
    /// # Errors
    /// `Busy` if another run has it; `Io` if nothing can be written there.
    pub(crate) fn take(place: &Place) -> Result<Self, OutputError> {
        let path = place.folder().join(place.hidden(".lock"));
        let refused = |error| place.refused(error);
        loop {
            let Some((file, is_new)) = open(&path).map_err(refused)? else { continue };
            let is_held = match file.try_lock() {
                Ok(()) => true,
                Err(TryLockError::WouldBlock) => {
                    return Err(OutputError::Busy { path: place.path.clone() });
                }
                // Without locks names at random keep runs apart, and the last one's output stays.
                Err(TryLockError::Error(error)) if error.kind() == ErrorKind::Unsupported => false,
                Err(TryLockError::Error(error)) => return Err(refused(error)),
            };
            if !is_at(&file, &path).map_err(refused)? {
                continue;
            }
            let lock = Self { path, _file: file };
            if is_held && !is_new {
                place.remove_leftovers()?;
            }
            return Ok(lock);
        }
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        // A lock file that stays says no more than that there may be leftovers.
        let _ = fs::remove_file(&self.path);
    }
}

/// The lock file, and whether it is new; none if it was removed at this moment.
fn open(path: &Path) -> io::Result<Option<(File, bool)>> {
    match OpenOptions::new().write(true).create_new(true).open(path) {
        Ok(file) => return Ok(Some((file, true))),
        Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
        Err(error) => return Err(error),
    }
    match OpenOptions::new().write(true).open(path) {
        Ok(file) => Ok(Some((file, false))),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error),
    }
}

/// Whether a path still leads to an open file: its owner removes a lock file before giving it back.
fn is_at(file: &File, path: &Path) -> io::Result<bool> {
    match Handle::from_path(path) {
        Ok(found) => Ok(found == Handle::from_file(file.try_clone()?)?),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(false),
        Err(error) => Err(error),
    }
}
