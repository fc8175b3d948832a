//! Inputs on which a reader once failed, kept below `fixtures/fuzz`.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use sha2::{Digest, Sha256};

/// Largest input that is kept, in bytes.
const LARGEST: usize = 1 << 16;

/// The inputs in a folder, sorted by name; none if it is not there.
///
/// # Errors
/// If the folder cannot be read.
pub(super) fn inputs(folder: &Path) -> Result<Vec<PathBuf>> {
    if !folder.is_dir() {
        return Ok(Vec::new());
    }
    let context = || format!("cannot read {}", folder.display());
    let entries = fs::read_dir(folder).with_context(context)?;
    let mut files: Vec<_> = entries
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.is_file())
        .collect();
    files.sort();
    Ok(files)
}

/// Keeps an input under its checksum, unless it is large.
///
/// # Errors
/// If it cannot be written.
pub(super) fn keep(folder: &Path, input: &[u8]) -> Result<Option<PathBuf>> {
    if input.len() > LARGEST {
        return Ok(None);
    }
    let name = format!("{:.12x}", Sha256::digest(input));
    let path = folder.join(name);
    let context = || format!("cannot write {}", path.display());
    fs::create_dir_all(folder).with_context(context)?;
    output::write(&path, input).with_context(context)?;
    Ok(Some(path))
}
