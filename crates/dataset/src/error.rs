//! Everything that can go wrong between a file and a table.

use std::{io, path::PathBuf};

use crate::remark::StreamRole;

/// An error of reading, choosing or writing recordings and tables.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DatasetError {
    /// The operating system refused a file or folder.
    #[error("cannot {action} {path}: {source}")]
    Io {
        /// What was tried: `read`, `write`, ...
        action: &'static str,
        /// The file or folder.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// A file or folder could not be written.
    #[error(transparent)]
    Output(#[from] output::OutputError),
    /// A folder has no recording of the wanted format.
    #[error(
        "{path}: no recording of format {format} here, expected {expected}; check `path` and `format` in [recordings]"
    )]
    NoRecordings {
        /// The folder.
        path: PathBuf,
        /// The format's name.
        format: &'static str,
        /// What a recording looks like.
        expected: String,
    },
    /// Two recordings of a set have the same name.
    #[error(
        "{first} and {second} are both recording `{name}`, so their pushes would be mixed; rename one of them"
    )]
    DuplicateRecording {
        /// The name.
        name: String,
        /// The one.
        first: PathBuf,
        /// The other.
        second: PathBuf,
    },
    /// `sessions.csv` names none of a set's recordings.
    #[error(
        "{path}: none of its {rows} rows names a recording of this set: it has `{row}`, the set has `{recording}`; give the recordings' names, without the ending of files"
    )]
    SessionsOfOthers {
        /// The file.
        path: PathBuf,
        /// Rows in it.
        rows: usize,
        /// The first name in it.
        row: String,
        /// The first recording of the set.
        recording: String,
    },
    /// The format's name is not known.
    #[error("unknown recording format `{id}`, expected one of {known}")]
    UnknownFormat {
        /// The name given.
        id: String,
        /// The names allowed.
        known: String,
    },
    /// The build leaves out what is needed.
    #[error("{what} is not part of this build; rebuild with the feature `{feature}`")]
    FeatureOff {
        /// What was asked for.
        what: &'static str,
        /// The feature of this crate.
        feature: &'static str,
    },
    /// A file is not of its format, or is damaged beyond what can be skipped.
    #[error("{path}: byte {byte}: {what}")]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Where, from the start of the file.
        byte: u64,
        /// What is wrong, and what to do.
        what: String,
    },
    /// Reading would need more than the limits allow.
    #[error("{path}: at least {needed} {what}, more than the {limit} allowed; {remedy}")]
    OverLimit {
        /// The file.
        path: PathBuf,
        /// What there is too much of, in the plural.
        what: String,
        /// How much of it there is, as far as it is known.
        needed: u64,
        /// How much is allowed.
        limit: u64,
        /// What to do: the setting that raises the limit, or another file.
        remedy: String,
    },
    /// What should be read is no regular file.
    #[error("{path}: this is a {kind}; give a regular file")]
    NotAFile {
        /// The path.
        path: PathBuf,
        /// What it is.
        kind: &'static str,
    },
    /// A reader gave up on a file that it should have refused.
    #[error("{path}: the reader failed on this file, which must be damaged: {what}")]
    ReaderFailed {
        /// The file.
        path: PathBuf,
        /// What the reader said.
        what: String,
    },
    /// A line of a text file is wrong.
    #[error("{path}:{line}: {what}")]
    Parse {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: u64,
        /// What is wrong, and what to do.
        what: String,
    },
    /// The topic, file or data set named in the manifest is not in the recording.
    #[error(
        "{path}: no `{topic}` for the {stream} stream; set streams.{stream}.topic to one of: {available}"
    )]
    TopicMissing {
        /// The recording.
        path: PathBuf,
        /// The stream.
        stream: StreamRole,
        /// The name asked for.
        topic: String,
        /// What is there, with types.
        available: String,
    },
    /// No topic, or more than one, fits a stream for which the manifest names none.
    #[error(
        "{path}: {n_candidates} topics fit the {stream} stream; set streams.{stream}.topic to one of: {available}"
    )]
    TopicChoice {
        /// The recording.
        path: PathBuf,
        /// The stream.
        stream: StreamRole,
        /// How many fit.
        n_candidates: usize,
        /// What is there, with types.
        available: String,
    },
    /// A topic carries messages of several types.
    #[error(
        "{path}: topic {topic} of the {stream} stream carries messages of several types, {types}, which are not one stream; record them on topics of their own, or name another topic with streams.{stream}.topic"
    )]
    TopicTypes {
        /// The recording.
        path: PathBuf,
        /// The stream.
        stream: StreamRole,
        /// The topic.
        topic: String,
        /// Its types.
        types: String,
    },
    /// A topic lacks the fields that its stream needs.
    #[error(
        "{path}: topic {topic} of type {type_name} does not serve as the {stream} stream: {what}"
    )]
    FieldMissing {
        /// The recording.
        path: PathBuf,
        /// The stream.
        stream: StreamRole,
        /// The topic.
        topic: String,
        /// Its type.
        type_name: String,
        /// What is missing, and what to set.
        what: String,
    },
    /// A frame is not in the recording.
    #[error("{path}: no frame `{frame}` for the {stream} stream; the recording has: {available}")]
    FrameMissing {
        /// The recording.
        path: PathBuf,
        /// The stream.
        stream: StreamRole,
        /// The frame asked for.
        frame: String,
        /// What is there.
        available: String,
    },
    /// A stream without a single sample.
    #[error(
        "{path}: the {stream} stream ({topic}) has no samples; record it again or name another topic"
    )]
    NoSamples {
        /// The recording.
        path: PathBuf,
        /// The stream.
        stream: StreamRole,
        /// Topic, file or data set.
        topic: String,
    },
    /// More than half of a stream's rows cannot be used.
    #[error("{path}: {excluded} of {total} rows of the {stream} stream cannot be used: {what}")]
    MostlyUnusable {
        /// The recording.
        path: PathBuf,
        /// The stream.
        stream: StreamRole,
        /// Rows excluded.
        excluded: u64,
        /// Rows read.
        total: u64,
        /// The most frequent reason with its first place, and what to do.
        what: String,
    },
    /// One shape is asked for of recordings that do not hold several.
    #[error(
        "{path}: the files of this set do not tell pushes of {shape} from others; give a set of end points, or name the object in the manifest"
    )]
    ShapeOfFiles {
        /// The set's folder.
        path: PathBuf,
        /// The shape asked for.
        shape: String,
    },
    /// A recording cannot be written in a format.
    #[error("cannot write {path} as {format}: {what}")]
    Unwritable {
        /// The file or folder.
        path: PathBuf,
        /// The format's name.
        format: &'static str,
        /// Why not, and what to do.
        what: String,
    },

    /// Samples through which no spline can be laid.
    #[error("spline: {what}")]
    SplineKnots {
        /// What is wrong with knots, values, noise or penalty.
        what: String,
    },
    /// A key of the manifest has a value that is not allowed.
    #[error("{path}:{line}: {key} = {value}{unit} is not allowed, expected {allowed}")]
    Manifest {
        /// The manifest.
        path: PathBuf,
        /// The line, from 1; 0 where the key is missing.
        line: u64,
        /// The key with its table, e.g. `object.side_m`.
        key: String,
        /// The value given, or `(missing)`.
        value: String,
        /// Its unit with a space before it, or nothing.
        unit: &'static str,
        /// What would be allowed.
        allowed: String,
    },
    /// A folder has neither a manifest nor the look of a known data set.
    #[error(
        "{path}: no dataset.toml, and no preset fits ({presets}); write one with `pushlab init`"
    )]
    NoManifest {
        /// The folder.
        path: PathBuf,
        /// The presets that were tried.
        presets: String,
    },
    /// A setting of the ingest is out of its range.
    #[error("{name} must be {allowed}, got {value}{unit}")]
    Setting {
        /// The setting.
        name: &'static str,
        /// The value given.
        value: f64,
        /// Its unit with a space before it, or nothing.
        unit: &'static str,
        /// What is allowed.
        allowed: &'static str,
    },
    /// No push of a whole set could be used.
    #[error("{path}: none of {recordings} recordings gave a usable push; the first: {reason}")]
    NothingUsable {
        /// The set's folder.
        path: PathBuf,
        /// How many recordings were tried.
        recordings: usize,
        /// Why the first push was excluded.
        reason: String,
    },
    /// Parts of a set that do not go together.
    #[error("{what}")]
    Parts {
        /// What is wrong, and what to do.
        what: String,
    },
    /// A table lacks a column.
    #[error("{path}: no column `{column}`; the table has: {found}")]
    ColumnMissing {
        /// The table.
        path: PathBuf,
        /// The column.
        column: String,
        /// The columns that are there.
        found: String,
    },
    /// A table has a column more than once.
    #[error(
        "{path}: column `{column}` is there more than once, as number {} and {}; keep one of them",
        places[0], places[1]
    )]
    ColumnTwice {
        /// The table.
        path: PathBuf,
        /// The column.
        column: String,
        /// Two of its places, from 1.
        places: [usize; 2],
    },
    /// A table has too few rows to learn anything from.
    #[error("{path}: the table has {rows} row(s); at least 2 are needed, ingest more pushes")]
    TableTooShort {
        /// The table.
        path: PathBuf,
        /// Rows found.
        rows: usize,
    },
    /// A Parquet file cannot be read or written.
    #[error("{path}: {what}")]
    Parquet {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        what: String,
    },
}

impl DatasetError {
    pub(crate) fn io(action: &'static str, path: &std::path::Path, source: io::Error) -> Self {
        Self::Io { action, path: path.into(), source }
    }
}
