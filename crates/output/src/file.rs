//! One file that appears whole or not at all.

use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::error::OutputError;
use crate::lock::Lock;
use crate::place::{Existing, Place};

/// A file to be written: its place is checked and taken before the work begins.
#[derive(Debug)]
pub struct OutputFile {
    place: Place,
    existing: Existing,
    _lock: Lock,
}

impl OutputFile {
    /// Takes the place of a file, so that no work is done in vain.
    ///
    /// A link is followed: what it leads to is written, beside where that is.
    ///
    /// # Errors
    /// `NoFolder`; `Unfit` for a folder, a device, a read-only file or a link that leads nowhere;
    /// `Exists` if it may not be replaced; `Busy` while another run writes it; `Io` if nothing can
    /// be written there.
    pub fn new(path: &Path, existing: Existing) -> Result<Self, OutputError> {
        Self::apart_from(&[], path, existing)
    }

    /// The same, and makes sure first that it is none of the inputs, under whatever name, nor lies
    /// in one.
    ///
    /// # Errors
    /// `Input`, and as [`Self::new`].
    pub fn apart_from(
        inputs: &[PathBuf],
        path: &Path,
        existing: Existing,
    ) -> Result<Self, OutputError> {
        let place = Place::of(path)?;
        place.check_apart_from(inputs)?;
        check(&place, existing)?;
        let lock = Lock::take(&place)?;
        // Another run may have ended in between.
        check(&place, existing)?;
        Ok(Self { place, existing, _lock: lock })
    }

    /// The path, as it was named.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.place.path
    }

    /// An empty file under a temporary name beside the output; it is removed when dropped.
    ///
    /// # Errors
    /// `Io`.
    pub fn begin(&self) -> Result<NamedTempFile, OutputError> {
        self.place.temporary_file()
    }

    /// Gives a file of [`Self::begin`] the output's name, when its bytes are on the disk.
    ///
    /// # Errors
    /// `Exists` if something else has written the output meanwhile and may not be replaced; `Io`.
    pub fn finish(self, part: NamedTempFile) -> Result<(), OutputError> {
        part.as_file().sync_all().map_err(|error| self.place.refused(error))?;
        let named = match self.existing {
            Existing::Refuse => part.persist_noclobber(&self.place.target),
            Existing::Replace => part.persist(&self.place.target),
        };
        named.map_err(|failed| match failed.error.kind() {
            ErrorKind::AlreadyExists => OutputError::Exists { path: self.place.path.clone() },
            _ => self.place.refused(failed.error),
        })?;
        self.place.sync_folder()
    }

    /// Writes the whole file.
    ///
    /// # Errors
    /// As [`Self::begin`] and [`Self::finish`].
    pub fn write(self, bytes: impl AsRef<[u8]>) -> Result<(), OutputError> {
        let mut part = self.begin()?;
        part.write_all(bytes.as_ref()).map_err(|error| self.place.refused(error))?;
        self.finish(part)
    }
}

/// Writes a whole file, in place of what is there.
///
/// # Errors
/// As [`OutputFile`].
pub fn write(path: &Path, bytes: impl AsRef<[u8]>) -> Result<(), OutputError> {
    OutputFile::new(path, Existing::Replace)?.write(bytes)
}

fn check(place: &Place, existing: Existing) -> Result<(), OutputError> {
    let Some(found) = place.found() else { return Ok(()) };
    let path = place.path.clone();
    if found.is_dir() {
        return Err(OutputError::Unfit { path, what: "it is a folder; name a file" });
    }
    if !found.is_file() {
        let what = "it is neither a file nor a folder; name a file";
        return Err(OutputError::Unfit { path, what });
    }
    if existing == Existing::Refuse {
        return Err(OutputError::Exists { path });
    }
    if found.permissions().readonly() {
        let what = "it is read-only; name another file, or allow that it is written";
        return Err(OutputError::Unfit { path, what });
    }
    Ok(())
}
