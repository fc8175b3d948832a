//! One file that appears whole or not at all.

use std::io::{self, ErrorKind, Seek, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::error::OutputError;
use crate::lock::Lock;
use crate::place::{Existing, Place};

/// A file to be written: its place is checked and taken before the work begins.
#[derive(Debug)]
pub struct OutputFile(Target);

#[derive(Debug)]
enum Target {
    File { place: Place, existing: Existing, _lock: Lock },
    StandardOutput,
}

/// How people name standard output in place of a file.
const STANDARD_OUTPUT: &str = "-";

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
        Ok(Self(Target::File { place, existing, _lock: lock }))
    }

    /// Standard output in place of a file; it gets the bytes at once, when they are whole.
    #[must_use]
    pub fn standard_output() -> Self {
        Self(Target::StandardOutput)
    }

    /// Whether this is standard output.
    #[must_use]
    pub fn is_standard_output(&self) -> bool {
        matches!(self.0, Target::StandardOutput)
    }

    /// The path, as it was named; `-` for standard output.
    #[must_use]
    pub fn path(&self) -> &Path {
        match &self.0 {
            Target::File { place, .. } => &place.path,
            Target::StandardOutput => Path::new(STANDARD_OUTPUT),
        }
    }

    /// An empty file under a temporary name beside the output, or in the system's folder for such
    /// files; it is removed when dropped.
    ///
    /// # Errors
    /// `Io`.
    pub fn begin(&self) -> Result<NamedTempFile, OutputError> {
        match &self.0 {
            Target::File { place, .. } => place.temporary_file(),
            Target::StandardOutput => NamedTempFile::new().map_err(|error| self.refused(error)),
        }
    }

    /// Gives a file of [`Self::begin`] the output's name, when its bytes are on the disk.
    ///
    /// # Errors
    /// `Exists` if something else has written the output meanwhile and may not be replaced; `Io`.
    pub fn finish(self, mut part: NamedTempFile) -> Result<(), OutputError> {
        let (place, existing) = match &self.0 {
            Target::File { place, existing, .. } => (place, existing),
            Target::StandardOutput => return print(&mut part).map_err(|error| self.refused(error)),
        };
        part.as_file().sync_all().map_err(|error| self.refused(error))?;
        let named = match existing {
            Existing::Refuse => part.persist_noclobber(&place.target),
            Existing::Replace => part.persist(&place.target),
        };
        named.map_err(|failed| match failed.error.kind() {
            ErrorKind::AlreadyExists => OutputError::Exists { path: place.path.clone() },
            _ => self.refused(failed.error),
        })?;
        place.sync_folder()
    }

    /// Writes the whole file.
    ///
    /// # Errors
    /// As [`Self::begin`] and [`Self::finish`].
    pub fn write(self, bytes: impl AsRef<[u8]>) -> Result<(), OutputError> {
        let mut part = self.begin()?;
        part.write_all(bytes.as_ref()).map_err(|error| self.refused(error))?;
        self.finish(part)
    }

    fn refused(&self, error: io::Error) -> OutputError {
        match &self.0 {
            Target::File { place, .. } => place.refused(error),
            Target::StandardOutput => OutputError::io("write", self.path(), error),
        }
    }
}

fn print(part: &mut NamedTempFile) -> io::Result<()> {
    part.rewind()?;
    let mut stream = io::stdout().lock();
    io::copy(part.as_file_mut(), &mut stream)?;
    stream.flush()
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
