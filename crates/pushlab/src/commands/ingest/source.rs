//! What there is to ingest: recordings, or a table of others with its mapping.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use dataset::{
    MANIFEST_NAME, Preset, RecordingSet, TableMapping, all_formats, find_recordings, is_end_points,
};

use super::Args;
use crate::origin::readable;
use crate::step_source::open_set;

/// The input as it was recognized.
pub(super) enum Source {
    /// A recording set.
    Recordings(Box<RecordingSet>),
    /// A table in the form of others.
    Table {
        /// The file.
        path: PathBuf,
        /// How its columns become ours.
        mapping: Box<TableMapping>,
        /// The file that says so, if it is no preset.
        mapping_path: Option<PathBuf>,
    },
}

impl Source {
    /// Recognizes the input by the options and by what is there.
    ///
    /// # Errors
    /// If the input is neither, with the way to what was probably meant.
    pub(super) fn of(args: &Args) -> Result<Self> {
        let set = &args.set;
        readable(set)?;
        match (&args.mapping, args.preset) {
            (Some(mapping), _) => Self::table(set, TableMapping::read(mapping)?, Some(mapping)),
            (None, Some(Preset::MitTable)) => Self::table(set, TableMapping::mit_table()?, None),
            (None, Some(preset)) => {
                let set = open_set(set, Some(preset), args.shape.as_deref())?;
                Ok(Self::Recordings(Box::new(set)))
            }
            (None, None) if is_end_points(set) => {
                Ok(Self::Recordings(Box::new(open_set(set, None, None)?)))
            }
            (None, None) => Self::recognize(set),
        }
    }

    fn recognize(set: &Path) -> Result<Self> {
        if set.is_file() && set.extension().is_some_and(|ending| ending == "csv") {
            // What `init --preset mit-table` wrote into the table's folder.
            let beside = set.with_file_name(MANIFEST_NAME);
            match TableMapping::read(&beside) {
                Ok(mapping) => return Self::table(set, mapping, Some(&beside)),
                Err(_) => bail!(
                    "{} is a table and needs a mapping of its columns: give --preset mit-table or \
                     --mapping FILE; a step table of pushlab is read with `pushlab describe`",
                    set.display()
                ),
            }
        }
        if set.is_file() && all_formats().iter().any(|format| format.find(set).is_ok()) {
            bail!(
                "{} is one recording; give the folder that has its {MANIFEST_NAME}, which \
                 `pushlab init` writes",
                set.display()
            );
        }
        if let Some(table) = lone_table(set) {
            bail!(
                "{} holds tables and no recordings; give a table with the mapping of its columns: \
                 pushlab ingest {} --preset mit-table, or --mapping FILE",
                set.display(),
                table.display()
            );
        }
        Ok(Self::Recordings(Box::new(RecordingSet::open(set)?)))
    }

    fn table(set: &Path, mapping: TableMapping, mapping_path: Option<&Path>) -> Result<Self> {
        let inside = set.join("table.csv");
        let path = if inside.is_file() { inside } else { set.to_path_buf() };
        let mapping_path = mapping_path.map(Path::to_path_buf);
        Ok(Self::Table { path, mapping: Box::new(mapping), mapping_path })
    }
}

/// A CSV file of a folder that has neither a manifest nor recordings.
fn lone_table(dir: &Path) -> Option<PathBuf> {
    if !dir.is_dir() || dir.join(MANIFEST_NAME).exists() || find_recordings(dir).is_ok() {
        return None;
    }
    let files = fs::read_dir(dir).ok()?.filter_map(|entry| Some(entry.ok()?.path()));
    files.filter(|path| path.extension().is_some_and(|ending| ending == "csv")).min()
}
