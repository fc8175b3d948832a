//! Where a command writes: checked before its work begins, and taken until its end.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use dataset::{MANIFEST_NAME, Preset, RecordingSet};
use output::{Existing, OutputError, OutputFile, OutputFolder};

use crate::tool::file_ending::is_standard;
use crate::tool::origin::readable;
use crate::tool::recorded_steps::SET_FILES;

/// What every command that writes files may be told about those that exist.
///
/// There is no such option for folders: what else lies in one is not the command's to remove.
#[derive(Clone, clap::Args)]
pub(crate) struct Force {
    /// Replace an output file that exists; without it that is refused. Inputs are never replaced
    #[arg(long)]
    force: bool,
}

impl Force {
    /// For a command within a command, as if that was typed or not.
    pub(crate) fn typed(force: bool) -> Self {
        Self { force }
    }

    /// Takes the place of a file, or standard output.
    ///
    /// # Errors
    /// If it exists and may not be replaced, is an input or lies in one, or cannot be written, or
    /// if another run is writing it.
    pub(crate) fn file(&self, path: &Path, inputs: &Inputs) -> Result<OutputFile> {
        if is_standard(path) {
            return Ok(OutputFile::standard_output());
        }
        inputs.check_is_no_recording(path)?;
        let existing = if self.force { Existing::Replace } else { Existing::Refuse };
        match OutputFile::apart_from(&inputs.paths, path, existing) {
            Err(OutputError::Exists { path }) => bail!(
                "cannot write {}: it exists; name another file, or replace it with --force",
                path.display()
            ),
            taken => Ok(taken?),
        }
    }
}

/// Takes the place of a folder, which is new or empty.
///
/// # Errors
/// If it has files in it, is an input or lies in one, or cannot be written, or if another run is
/// writing it.
pub(crate) fn folder(path: &Path, inputs: &Inputs) -> Result<OutputFolder> {
    inputs.check_is_no_recording(path)?;
    Ok(OutputFolder::apart_from(&inputs.paths, path, Existing::Refuse)?)
}

/// What a command reads, and where nothing may be written.
#[derive(Default)]
pub(crate) struct Inputs {
    /// Files, and folders in which everything is input.
    pub(crate) paths: Vec<PathBuf>,
    /// Recordings among them that lie beside other files of their set.
    recordings: Vec<PathBuf>,
}

impl Inputs {
    /// The same with more files.
    pub(crate) fn with<'a>(mut self, files: impl IntoIterator<Item = &'a PathBuf>) -> Self {
        self.paths.extend(files.into_iter().cloned());
        self
    }

    /// Both.
    pub(crate) fn and(mut self, other: Self) -> Self {
        self.paths.extend(other.paths);
        self.recordings.extend(other.recordings);
        self
    }

    /// The same with a recording set, or with a table and what may lie beside it.
    ///
    /// A path where neither is adds itself alone: what is wrong with it is said when it is read.
    pub(crate) fn with_set(mut self, path: &Path, preset: Option<Preset>) -> Self {
        self.paths.extend(match path.is_dir() {
            true => vec![path.join("table.csv")],
            false => vec![path.to_owned(), path.with_file_name(MANIFEST_NAME)],
        });
        // Reading a device or a pipe may never end.
        if readable(path).is_err() {
            return self;
        }
        let set = match preset {
            Some(preset) => RecordingSet::open_with_preset(path, preset),
            None => RecordingSet::open(path),
        };
        let Ok(set) = set else { return self };
        self.paths.extend(SET_FILES.map(|name| set.dir().join(name)));
        let own = set.dir().canonicalize().ok();
        for recording in set.recordings() {
            let folder = recording.parent().unwrap_or(recording);
            if folder.canonicalize().ok() == own {
                // Not every file of that kind is read as end points.
                self.recordings.extend((!set.is_of_end_points()).then(|| recording.clone()));
                self.paths.push(recording.clone());
            } else if self.paths.last().is_none_or(|last| last != folder) {
                // A file beside them would be taken for one of them.
                self.paths.push(folder.to_owned());
            }
        }
        self
    }

    /// Refuses a name that would make an output a recording of the set that is read.
    fn check_is_no_recording(&self, path: &Path) -> Result<()> {
        let folder = |path: &Path| Path::new(".").join(path).parent()?.canonicalize().ok();
        let is_like = |recording: &&PathBuf| {
            recording.is_file()
                && recording.extension() == path.extension()
                && folder(path).is_some_and(|own| folder(recording) == Some(own))
        };
        match self.recordings.iter().find(is_like) {
            Some(recording) => bail!(
                "cannot write {}: it would be taken for a recording, as {}; name another folder",
                path.display(),
                recording.display()
            ),
            None => Ok(()),
        }
    }
}
