//! What a recording is called.

use std::{collections::BTreeMap, path::Path, path::PathBuf};

use crate::error::DatasetError;

/// Endings of the files that the formats of this crate read.
pub(crate) const ENDINGS: [&str; 5] = ["mcap", "json", "h5", "hdf5", "bag"];

/// The name of a recording: that of a folder as a whole, that of a file without its format's ending.
///
/// Other dots belong to the name: `angle-0.1` and `angle-0.2` are two recordings.
///
/// - `endings`: of the format's files, without the dot.
#[must_use]
pub fn recording_name(path: &Path, endings: &[&str]) -> String {
    let whole = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
    let ending = path.extension().and_then(|ending| ending.to_str());
    match (ending.filter(|ending| endings.contains(ending)), path.file_stem()) {
        (Some(_), Some(stem)) if !path.is_dir() => stem.to_string_lossy().into_owned(),
        _ => whole.into_owned(),
    }
}

/// The names of a set's recordings, in their order.
///
/// # Errors
/// `DuplicateRecording` if two have the same: their pushes would be taken for those of one.
pub(crate) fn distinct_names(
    recordings: &[PathBuf],
    endings: &[&str],
) -> Result<Vec<String>, DatasetError> {
    let mut known: BTreeMap<String, &PathBuf> = BTreeMap::new();
    let mut names = Vec::with_capacity(recordings.len());
    for path in recordings {
        let name = recording_name(path, endings);
        if let Some(first) = known.insert(name.clone(), path) {
            let (first, second) = (first.clone(), path.clone());
            return Err(DatasetError::DuplicateRecording { name, first, second });
        }
        names.push(name);
    }
    Ok(names)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::{ENDINGS, recording_name};
    use crate::formats::list::all_formats;

    #[test]
    fn only_the_ending_of_the_format_is_no_part_of_a_name() {
        let dir = tempfile::tempdir().unwrap();
        let folder = dir.path().join("angle-0.1");
        std::fs::create_dir(&folder).unwrap();
        assert_eq!(recording_name(&folder, &ENDINGS), "angle-0.1");
        for (path, name) in [
            ("a/i=0.000_t=-0.175.json", "i=0.000_t=-0.175"),
            ("a/i=0.000_t=-0.175", "i=0.000_t=-0.175"),
            ("push.mcap", "push"),
            ("push.1.bag", "push.1"),
            ("push.log", "push.log"),
        ] {
            assert_eq!(recording_name(Path::new(path), &ENDINGS), name);
        }
        assert_eq!(recording_name(Path::new("push.1.log"), &["log"]), "push.1");
        std::fs::create_dir(dir.path().join("push.json")).unwrap();
        assert_eq!(recording_name(&dir.path().join("push.json"), &ENDINGS), "push.json");
    }

    #[test]
    fn every_format_of_this_crate_tells_its_endings() {
        // Files of end points are known by what is in them, and hold recordings of other names.
        for format in all_formats().iter().filter(|format| format.id() != "endpoints") {
            let endings = format.endings();
            assert!(endings.iter().all(|ending| ENDINGS.contains(ending)), "{}", format.id());
            let dir = tempfile::tempdir().unwrap();
            for ending in endings {
                std::fs::write(dir.path().join(format!("a.1.{ending}")), "").unwrap();
            }
            let found = format.find(dir.path()).map_or(0, |found| found.len());
            assert_eq!(found, endings.len(), "{}", format.id());
        }
    }
}
