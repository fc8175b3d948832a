//! Where an output goes, and the names that stand in for it until it is whole.

use std::ffi::OsString;
use std::fs::{self, File, Metadata};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use tempfile::{Builder, NamedTempFile, TempDir};

use crate::error::OutputError;

/// What to do with an output that is there already.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Existing {
    /// Leave it and fail. An empty folder is taken as it is.
    Refuse,
    /// Replace it when the new one is whole.
    Replace,
}

/// A path whose folder is there, with links followed.
#[derive(Debug)]
pub(crate) struct Place {
    /// As it was named, for messages.
    pub(crate) path: PathBuf,
    /// What a link at the path leads to, else the path.
    pub(crate) target: PathBuf,
}

/// Between the output's name and the letters at random, and at the end of a temporary name.
const SUFFIX: &str = ".part";
const N_RANDOM: usize = 6;

impl Place {
    pub(crate) fn of(path: &Path) -> Result<Self, OutputError> {
        let unfit = |what| OutputError::Unfit { path: path.into(), what };
        if path.file_name().is_none() {
            return Err(unfit("it needs a name of its own; name a new one"));
        }
        let is_link = fs::symlink_metadata(path).is_ok_and(|found| found.is_symlink());
        let target = if is_link {
            let nowhere = "it is a link that leads nowhere; remove it or name another output";
            path.canonicalize().map_err(|_| unfit(nowhere))?
        } else {
            path.to_path_buf()
        };
        let place = Self { path: path.into(), target };
        let folder = place.folder();
        if !folder.is_dir() {
            return Err(OutputError::NoFolder { path: path.into(), folder: folder.into() });
        }
        Ok(place)
    }

    /// The folder that holds the output, and its temporary files beside it.
    pub(crate) fn folder(&self) -> &Path {
        match self.target.parent() {
            Some(folder) if folder != Path::new("") => folder,
            _ => Path::new("."),
        }
    }

    /// What is at the place.
    pub(crate) fn found(&self) -> Option<Metadata> {
        fs::metadata(&self.target).ok()
    }

    /// `.NAME` and an ending, beside the output.
    pub(crate) fn hidden(&self, ending: &str) -> OsString {
        let mut name = OsString::from(".");
        name.push(self.target.file_name().unwrap_or_default());
        name.push(ending);
        name
    }

    pub(crate) fn temporary_file(&self) -> Result<NamedTempFile, OutputError> {
        let prefix = self.hidden(".");
        let mut builder = Builder::new();
        builder.prefix(&prefix).suffix(SUFFIX).rand_bytes(N_RANDOM);
        // As any other new file has them; the system takes off what the user's mask forbids.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let file = builder.tempfile_in(self.folder());
        file.map_err(|error| self.refused(error))
    }

    pub(crate) fn temporary_folder(&self) -> Result<TempDir, OutputError> {
        let prefix = self.hidden(".");
        let mut builder = Builder::new();
        builder.prefix(&prefix).suffix(SUFFIX).rand_bytes(N_RANDOM);
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o777));
        let folder = builder.tempdir_in(self.folder());
        folder.map_err(|error| self.refused(error))
    }

    /// Removes what killed runs left of this output; the caller holds its lock.
    pub(crate) fn remove_leftovers(&self) -> Result<(), OutputError> {
        let read = |error| OutputError::io("read", self.folder(), error);
        for entry in fs::read_dir(self.folder()).map_err(read)? {
            let entry = entry.map_err(read)?;
            if self.is_leftover(&entry.file_name()) {
                let path = entry.path();
                let removed =
                    if path.is_dir() { fs::remove_dir_all(&path) } else { fs::remove_file(&path) };
                removed.map_err(|error| OutputError::io("remove", &path, error))?;
            }
        }
        Ok(())
    }

    fn is_leftover(&self, name: &std::ffi::OsStr) -> bool {
        let (prefix, name) = (self.hidden("."), name.as_encoded_bytes());
        let random = name
            .strip_prefix(prefix.as_encoded_bytes())
            .and_then(|rest| rest.strip_suffix(SUFFIX.as_bytes()));
        // An output whose name begins with this one's has more between the two.
        random.is_some_and(|letters| {
            letters.len() == N_RANDOM && letters.iter().all(u8::is_ascii_alphanumeric)
        })
    }

    /// Makes sure that the output neither is an input nor lies in one.
    pub(crate) fn check_apart_from(&self, inputs: &[PathBuf]) -> Result<(), OutputError> {
        let Ok(folder) = self.folder().canonicalize() else { return Ok(()) };
        let own = folder.join(self.target.file_name().unwrap_or_default());
        for input in inputs {
            let holds = input.canonicalize().is_ok_and(|input| own.starts_with(input));
            // To open a pipe may never end.
            let is_same = || same_file::is_same_file(&self.target, input).unwrap_or(false);
            if holds || input.is_file() && is_same() {
                return Err(OutputError::Input { path: self.path.clone(), input: input.clone() });
            }
        }
        Ok(())
    }

    /// Makes the new name last through a power cut.
    pub(crate) fn sync_folder(&self) -> Result<(), OutputError> {
        sync_folder(self.folder()).map_err(|error| self.refused(error))
    }

    pub(crate) fn refused(&self, error: io::Error) -> OutputError {
        // The random name in the message of `tempfile` says nothing to a reader.
        let source = error.raw_os_error().map_or(error, io::Error::from_raw_os_error);
        OutputError::io("write", &self.path, source)
    }
}

/// Writes a folder's list of names to the disk, where the system can do that.
pub(crate) fn sync_folder(folder: &Path) -> io::Result<()> {
    if !cfg!(unix) {
        return Ok(());
    }
    match File::open(folder).and_then(|folder| folder.sync_all()) {
        // Some file systems cannot, and some folders may be written but not opened.
        Err(error)
            if matches!(
                error.kind(),
                ErrorKind::InvalidInput | ErrorKind::Unsupported | ErrorKind::PermissionDenied
            ) =>
        {
            Ok(())
        }
        result => result,
    }
}
