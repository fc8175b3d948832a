//! A recording set: a folder with a manifest, or public data that a preset knows.

use std::path::{Path, PathBuf};

use crate::formats::end_points::END_POINTS;
use crate::formats::format::{ANY_FORMAT, LogFormat};
use crate::formats::list::{all_formats, format_by_id};
use crate::manifest::object::{ObjectChoice, ObjectSpec};
use crate::manifest::part::Part;
use crate::manifest::preset::Preset;
use crate::manifest::session::{Session, Sessions, read_sessions};
use crate::manifest::unread::unread_formats;
use crate::manifest::{MANIFEST_NAME, Manifest};
use crate::recording::Recording;
use crate::recording::name::{distinct_names, recording_name};
use crate::recording::settings::Streams;
use crate::{error::DatasetError, remark::Remark};

/// The recordings of a set, found but not yet read.
pub struct RecordingSet {
    dir: PathBuf,
    manifest: Manifest,
    preset: Option<Preset>,
    format: &'static dyn LogFormat,
    recordings: Vec<PathBuf>,
    sessions: Sessions,
    remarks: Vec<Remark>,
    part: Option<Part>,
}

impl RecordingSet {
    /// Opens a folder with `dataset.toml`, the manifest itself, or a folder that a preset knows.
    ///
    /// # Errors
    /// `Io` for a path that is not there, `NoManifest` for a folder without manifest that no preset
    /// fits, `NoRecordings` for an empty set, and what reading the manifest or `sessions.csv` may
    /// say.
    pub fn open(path: &Path) -> Result<Self, DatasetError> {
        let is_dir =
            std::fs::metadata(path).map_err(|e| DatasetError::io("read", path, e))?.is_dir();
        let manifest_path = if is_dir { path.join(MANIFEST_NAME) } else { path.to_path_buf() };
        if manifest_path.exists() {
            let dir = manifest_path.parent().unwrap_or(Path::new(".")).to_path_buf();
            return Self::with_manifest(dir, Manifest::read(&manifest_path)?, None, None);
        }
        match Preset::of_recordings(path) {
            Some(preset) => Self::open_with_preset(path, preset),
            None => Err(DatasetError::NoManifest {
                path: path.into(),
                presets: Preset::ALL.map(Preset::name).join(", "),
            }),
        }
    }

    /// Opens a folder with `dataset.toml` whose recordings are in a format of the caller's own; the
    /// manifest names no other.
    ///
    /// # Errors
    /// As [`RecordingSet::open`], and what the format says; `UnknownFormat` if the manifest names
    /// another format.
    pub fn open_with_format(
        dir: &Path,
        format: &'static dyn LogFormat,
    ) -> Result<Self, DatasetError> {
        let manifest = Manifest::read(&dir.join(MANIFEST_NAME))?;
        match &manifest.recordings.format {
            Some(other) if other != format.id() => {
                let (id, known) = (other.clone(), format.id().to_owned());
                Err(DatasetError::UnknownFormat { id, known })
            }
            _ => Self::with_manifest(dir.to_path_buf(), manifest, None, Some(format)),
        }
    }

    /// Opens a folder of recordings, or one file of end points, by a preset, whatever manifest there may
    /// be.
    ///
    /// # Errors
    /// As [`RecordingSet::open`]; `NoManifest` for a preset of tables.
    pub fn open_with_preset(path: &Path, preset: Preset) -> Result<Self, DatasetError> {
        let mut manifest = preset.manifest().ok_or_else(|| DatasetError::NoManifest {
            path: path.into(),
            presets: format!("{} is for tables", preset.name()),
        })??;
        let mut dir = path.to_path_buf();
        if let Some(name) = path.file_name().filter(|_| path.is_file()) {
            manifest.recordings.path = name.to_string_lossy().into_owned();
            dir.pop();
        }
        Self::with_manifest(dir, manifest, Some(preset), None)
    }

    /// The same set about one object, where a file has pushes of several.
    ///
    /// # Errors
    /// `ShapeOfFiles` where the set's files do not tell them apart.
    pub fn about(mut self, object: ObjectSpec) -> Result<Self, DatasetError> {
        if !self.is_of_end_points() {
            return Err(DatasetError::ShapeOfFiles { path: self.dir, shape: object.name });
        }
        self.manifest.object = ObjectChoice::Fixed(Box::new(object));
        Ok(self)
    }

    /// The same set with one part of its recordings.
    #[must_use]
    pub fn in_part(mut self, part: Part) -> Self {
        let range = part.range(self.recordings.len());
        self.recordings = self.recordings.drain(range).collect();
        self.part = Some(part);
        self
    }

    /// Which part of the set its recordings are, if not all.
    #[must_use]
    pub fn part(&self) -> Option<Part> {
        self.part
    }

    /// Whether its pushes are known by the object's poses before and after alone.
    #[must_use]
    pub fn is_of_end_points(&self) -> bool {
        self.format.id() == END_POINTS
    }

    fn with_manifest(
        dir: PathBuf,
        manifest: Manifest,
        preset: Option<Preset>,
        own_format: Option<&'static dyn LogFormat>,
    ) -> Result<Self, DatasetError> {
        let folder = dir.join(&manifest.recordings.path);
        let (format, recordings) = match (own_format, &manifest.recordings.format) {
            (Some(format), _) => (format, format.find_streams(&folder, &manifest.streams)?),
            (None, Some(id)) => {
                let format = format_by_id(id)?;
                (format, format.find_streams(&folder, &manifest.streams)?)
            }
            (None, None) => find_any(&folder, &manifest.streams)?,
        };
        let names = distinct_names(&recordings, format.endings())?;
        let sessions = read_sessions(&dir)?;
        let mut remarks = unread_formats(&folder, format);
        // A format of a user's own may name its recordings otherwise.
        if own_format.is_none_or(|format| !format.endings().is_empty()) {
            remarks.extend(sessions.remarks(&names)?);
        }
        Ok(Self { dir, manifest, preset, format, recordings, sessions, remarks, part: None })
    }

    /// The same set with its recordings in another format, where they lie in more than one.
    ///
    /// # Errors
    /// `UnknownFormat`, `FeatureOff`, `Io` or `NoRecordings`.
    pub fn in_format(&self, id: &str) -> Result<Self, DatasetError> {
        let format = format_by_id(id)?;
        let mut manifest = self.manifest.clone();
        manifest.recordings.format = Some(format.id().to_owned());
        Self::with_manifest(self.dir.clone(), manifest, self.preset, None)
    }

    /// The set's folder.
    #[must_use]
    pub fn dir(&self) -> &Path {
        &self.dir
    }

    /// Its manifest, read or from a preset.
    #[must_use]
    pub fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    /// The preset that stood in for a manifest.
    #[must_use]
    pub fn preset(&self) -> Option<Preset> {
        self.preset
    }

    /// The format of its recordings.
    #[must_use]
    pub fn format(&self) -> &'static dyn LogFormat {
        self.format
    }

    /// The recordings, sorted by name.
    #[must_use]
    pub fn recordings(&self) -> &[PathBuf] {
        &self.recordings
    }

    /// The name of one of its recordings.
    #[must_use]
    pub fn name_of(&self, recording: &Path) -> String {
        recording_name(recording, self.format.endings())
    }

    /// What lies beside its recordings and is not read, and what `sessions.csv` does not say.
    #[must_use]
    pub fn remarks(&self) -> &[Remark] {
        &self.remarks
    }

    /// Reads one of the recordings, within the limits of the manifest.
    ///
    /// # Errors
    /// As [`LogFormat::read`].
    pub fn read(&self, recording: &Path) -> Result<Recording, DatasetError> {
        self.format.read(recording, &self.manifest.streams, &self.manifest.limits)
    }

    /// What `sessions.csv` says of a recording.
    #[must_use]
    pub fn session(&self, recording: &str) -> Option<&Session> {
        self.sessions.get(recording)
    }
}

/// The first format, in the order of the list, that finds recordings in a folder.
fn find_any(
    dir: &Path,
    streams: &Streams,
) -> Result<(&'static dyn LogFormat, Vec<PathBuf>), DatasetError> {
    for &format in all_formats() {
        match format.find_streams(dir, streams) {
            Ok(recordings) => return Ok((format, recordings)),
            Err(DatasetError::NoRecordings { .. }) => {}
            Err(error) => return Err(error),
        }
    }
    Err(DatasetError::NoRecordings {
        path: dir.into(),
        format: "any",
        expected: ANY_FORMAT.to_owned(),
    })
}
