//! One folder that appears whole or not at all.

use std::fs::{self, OpenOptions};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use tempfile::TempDir;

use crate::error::OutputError;
use crate::lock::Lock;
use crate::place::{Existing, Place, sync_folder};

/// A folder under a temporary name, until it is whole; removed when dropped before.
#[derive(Debug)]
pub struct PartFolder {
    folder: TempDir,
    /// Of the output, for messages.
    path: PathBuf,
}

impl PartFolder {
    /// Where it is now.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.folder.path()
    }

    /// Writes a file of the folder.
    ///
    /// # Errors
    /// `Io`.
    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> Result<(), OutputError> {
        let written = fs::write(self.folder.path().join(name), bytes);
        written.map_err(|error| OutputError::io("write", &self.path.join(name), error))
    }
}

/// A folder to be filled: its place is checked and taken before the work begins.
#[derive(Debug)]
pub struct OutputFolder {
    place: Place,
    existing: Existing,
    _lock: Lock,
}

impl OutputFolder {
    /// Takes the place of a folder, which is new or empty unless it may be replaced.
    ///
    /// # Errors
    /// `NoFolder`; `Unfit` for a file or a path without a name; `NotEmpty` if it may not be
    /// replaced; `Busy` while another run writes it; `Io` if nothing can be written there.
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

    /// An empty folder under a temporary name beside the output; it is removed when dropped.
    ///
    /// # Errors
    /// `Io`.
    pub fn begin(&self) -> Result<PartFolder, OutputError> {
        Ok(PartFolder { folder: self.place.temporary_folder()?, path: self.place.path.clone() })
    }

    /// Gives a folder of [`Self::begin`] the output's name, when its files are on the disk.
    ///
    /// A folder that is replaced is removed first: if the run is killed then, there is none.
    ///
    /// # Errors
    /// `NotEmpty` if something else has filled the output meanwhile and it may not be replaced;
    /// `Io`.
    pub fn finish(self, part: PartFolder) -> Result<(), OutputError> {
        let refused = |error| self.place.refused(error);
        sync(part.path()).map_err(refused)?;
        if self.place.found().is_some() {
            let target = &self.place.target;
            match self.existing {
                Existing::Refuse => fs::remove_dir(target),
                Existing::Replace => fs::remove_dir_all(target),
            }
            .map_err(|error| self.not_empty(error))?;
        }
        fs::rename(part.path(), &self.place.target).map_err(|error| self.not_empty(error))?;
        // It has another name now: there is nothing to remove.
        let _ = part.folder.keep();
        self.place.sync_folder()
    }

    /// Fills the folder.
    ///
    /// # Errors
    /// What `fill` says, and as [`Self::begin`] and [`Self::finish`].
    pub fn fill<T, E: From<OutputError>>(
        self,
        fill: impl FnOnce(&PartFolder) -> Result<T, E>,
    ) -> Result<T, E> {
        let part = self.begin()?;
        let filled = fill(&part)?;
        self.finish(part)?;
        Ok(filled)
    }

    fn not_empty(&self, error: io::Error) -> OutputError {
        match error.kind() {
            ErrorKind::DirectoryNotEmpty | ErrorKind::AlreadyExists => {
                OutputError::NotEmpty { path: self.place.path.clone() }
            }
            _ => self.place.refused(error),
        }
    }
}

fn check(place: &Place, existing: Existing) -> Result<(), OutputError> {
    let Some(found) = place.found() else { return Ok(()) };
    let path = place.path.clone();
    if !found.is_dir() {
        return Err(OutputError::Unfit { path, what: "it is a file; name a new folder" });
    }
    let mut entries = fs::read_dir(&place.target).map_err(|error| place.refused(error))?;
    if existing == Existing::Refuse && entries.next().is_some() {
        return Err(OutputError::NotEmpty { path });
    }
    Ok(())
}

/// Writes a folder's files, and those of the folders in it, to the disk.
fn sync(folder: &Path) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            sync(&path)?;
        } else {
            OpenOptions::new().write(true).open(&path)?.sync_all()?;
        }
    }
    sync_folder(folder)
}
