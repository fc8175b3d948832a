//! Simulated recordings that are kept below `target/` until what makes them changes.

use std::fs;
use std::path::{Path, PathBuf};
use std::thread;
use std::time::Duration;

use anyhow::{Context, Result};
use output::{Existing, OutputError, OutputFolder};
use plant::GenerateSettings;
use sha2::{Digest, Sha256};

use crate::workspace::workspace_root;

/// What the recordings depend on besides the settings.
const SOURCES: [&str; 4] =
    ["Cargo.lock", "crates/planar/src", "crates/plant/src", "crates/dataset/src/writers"];
/// The file with the digest of all others.
const SEAL: &str = "sha256";

/// Digest of settings and of what turns them into recordings.
///
/// # Errors
/// A source that cannot be read.
pub fn key(settings: &[GenerateSettings]) -> Result<String> {
    let mut files = Vec::new();
    for source in SOURCES {
        add_files(&workspace_root().join(source), &mut files)?;
    }
    Ok(format!("{settings:?}\n{}", digest(&workspace_root(), files)?))
}

/// How often a folder that another run is making is looked at.
const GLANCE: Duration = Duration::from_millis(200);

/// Fills a folder by `make`, unless it was filled for the same key and is as it was left.
///
/// Where another run is making it, waits for that one's.
///
/// # Errors
/// What `make` says; a folder that cannot be read or written.
pub fn made_once(folder: &Path, key: &str, make: impl FnOnce(&Path) -> Result<()>) -> Result<()> {
    if let Some(parent) = folder.parent() {
        let made = fs::create_dir_all(parent);
        made.with_context(|| format!("cannot create {}", parent.display()))?;
    }
    let output = loop {
        match OutputFolder::new(folder, Existing::Replace) {
            Err(OutputError::Busy { .. }) => thread::sleep(GLANCE),
            taken => break taken?,
        }
    };
    let sealed = fs::read_to_string(folder.join(SEAL)).unwrap_or_default();
    if !sealed.is_empty() && seal(folder, key).is_ok_and(|seal| seal == sealed) {
        return Ok(());
    }
    output.fill(|part| {
        make(part.path())?;
        Ok(part.write(SEAL, seal(part.path(), key)?)?)
    })
}

/// Digest of a key and of every file below a folder but the seal itself.
fn seal(folder: &Path, key: &str) -> Result<String> {
    let mut files = Vec::new();
    add_files(folder, &mut files)?;
    files.retain(|file| *file != folder.join(SEAL));
    Ok(format!("{:x}", Sha256::digest(format!("{key}\n{}", digest(folder, files)?))))
}

/// The files at or below a path.
fn add_files(path: &Path, files: &mut Vec<PathBuf>) -> Result<()> {
    if path.is_dir() {
        let entries = fs::read_dir(path).with_context(|| format!("cannot read {}", path.display()));
        for entry in entries? {
            add_files(&entry?.path(), files)?;
        }
    } else {
        files.push(path.to_path_buf());
    }
    Ok(())
}

/// Digest of files with their names from a root on, in whatever order they are given.
fn digest(root: &Path, mut files: Vec<PathBuf>) -> Result<String> {
    files.sort();
    let mut all = Sha256::new();
    for file in files {
        let bytes = fs::read(&file).with_context(|| format!("cannot read {}", file.display()))?;
        all.update(file.strip_prefix(root)?.to_string_lossy().as_bytes());
        all.update([0]);
        all.update(Sha256::digest(&bytes));
    }
    Ok(format!("{:x}", all.finalize()))
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;
    use std::fs;

    use anyhow::bail;

    use super::made_once;

    #[test]
    fn what_was_made_is_kept_until_key_or_files_change() {
        let parent = tempfile::tempdir().unwrap();
        let folder = parent.path().join("kept");
        let times = Cell::new(0);
        let ready = |key: &str| {
            made_once(&folder, key, |own| {
                times.set(times.get() + 1);
                fs::create_dir(own.join("set"))?;
                Ok(fs::write(own.join("set/push"), "1")?)
            })
            .unwrap();
            times.get()
        };
        assert_eq!([ready("a"), ready("a")], [1, 1]);
        assert_eq!(ready("b"), 2, "another key");
        fs::write(folder.join("set/push"), "2").unwrap();
        assert_eq!(ready("b"), 3, "a damaged file");
        fs::remove_file(folder.join("set/push")).unwrap();
        assert_eq!(ready("b"), 4, "a missing file");
        fs::write(folder.join("more"), "").unwrap();
        assert_eq!([ready("b"), ready("b")], [5, 5], "a file too many");
        assert_eq!(fs::read_dir(parent.path()).unwrap().count(), 1, "nothing is left beside it");
    }

    #[test]
    fn what_fails_leaves_what_was_there() {
        let parent = tempfile::tempdir().unwrap();
        let folder = parent.path().join("kept");
        made_once(&folder, "a", |own| Ok(fs::write(own.join("push"), "1")?)).unwrap();
        made_once(&folder, "b", |_| bail!("no")).unwrap_err();
        assert_eq!(fs::read_to_string(folder.join("push")).unwrap(), "1");
        assert_eq!(fs::read_dir(parent.path()).unwrap().count(), 1);
    }
}
