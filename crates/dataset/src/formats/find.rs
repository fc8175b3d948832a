//! Finding recordings in a folder.

use std::{
    fs,
    path::{Path, PathBuf},
};

use crate::error::DatasetError;

/// The entries of a folder that are recordings, sorted by name; a recording itself alone.
pub(super) fn find_recordings(
    dir: &Path,
    format: &'static str,
    expected: &str,
    is_recording: &dyn Fn(&Path) -> bool,
) -> Result<Vec<PathBuf>, DatasetError> {
    if is_recording(dir) {
        return Ok(vec![dir.into()]);
    }
    let io = |error| DatasetError::io("read", dir, error);
    let mut found = Vec::new();
    for entry in fs::read_dir(dir).map_err(io)? {
        let path = entry.map_err(io)?.path();
        if !is_unfinished(&path) && is_recording(&path) {
            found.push(path);
        }
    }
    if found.is_empty() {
        let (path, expected) = (dir.into(), expected.to_owned());
        return Err(DatasetError::NoRecordings { path, format, expected });
    }
    found.sort();
    Ok(found)
}

/// Whether a path is what a killed run left of a recording, under its temporary name.
fn is_unfinished(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().as_encoded_bytes();
    name.starts_with(b".") && name.ends_with(b".part")
}

/// The files of a folder with one of these endings, sorted by name; such a file itself alone.
pub(super) fn find_files(
    dir: &Path,
    format: &'static str,
    endings: &[&str],
) -> Result<Vec<PathBuf>, DatasetError> {
    let expected = format!("files NAME.{}", endings.first().unwrap_or(&""));
    find_recordings(dir, format, &expected, &|path| is_file_ending(path, endings))
}

/// Whether a path is a file with one of these endings.
pub(super) fn is_file_ending(path: &Path, endings: &[&str]) -> bool {
    let ending = path.extension().and_then(|ending| ending.to_str());
    path.is_file() && ending.is_some_and(|ending| endings.contains(&ending))
}
