//! Files that appear whole or not at all.

use std::fs;
use std::path::{Path, PathBuf};

use crate::data::Data;
use crate::error::ReportError;

/// A figure as it was written: where, and its SVG for a page.
#[derive(Debug, Clone)]
pub struct Drawn {
    pub(crate) folder: PathBuf,
    pub(crate) name: String,
    pub(crate) title: String,
    pub(crate) svg: String,
    pub(crate) data_extension: &'static str,
}

impl Drawn {
    pub(crate) fn new(
        folder: &Path,
        name: &str,
        title: &str,
        svg: String,
        data: &Data,
    ) -> Result<Self, ReportError> {
        check_name(name)?;
        Ok(Self {
            folder: folder.to_owned(),
            name: name.to_owned(),
            title: title.to_owned(),
            svg,
            data_extension: data.extension(),
        })
    }

    /// The figure's SVG text.
    pub fn svg(&self) -> &str {
        &self.svg
    }

    /// The file with an extension: `svg`, `png`, and `csv` or `json`.
    pub fn path(&self, extension: &str) -> PathBuf {
        self.folder.join(format!("{}.{extension}", self.name))
    }

    /// All files written.
    pub fn paths(&self) -> [PathBuf; 3] {
        ["svg", "png", self.data_extension].map(|extension| self.path(extension))
    }
}

/// Refuses names that would be awkward in a file system, a link or an anchor.
pub(crate) fn check_name(name: &str) -> Result<(), ReportError> {
    let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '.' | '_' | '-');
    if !name.is_empty() && !name.starts_with('.') && name.chars().all(plain) {
        return Ok(());
    }
    Err(ReportError::Name { name: name.to_owned() })
}

/// Writes beside the target under a temporary name, then renames.
pub(crate) fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), ReportError> {
    let failed = |path: &Path, source| ReportError::Write { path: path.to_owned(), source };
    let folder = path.parent().unwrap_or(Path::new(""));
    if !folder.as_os_str().is_empty() {
        fs::create_dir_all(folder).map_err(|source| failed(folder, source))?;
    }
    let mut hidden = std::ffi::OsString::from(".");
    hidden.push(path.file_name().unwrap_or_default());
    hidden.push(format!(".{}.tmp", std::process::id()));
    let temporary = folder.join(hidden);
    let written = fs::write(&temporary, bytes).and_then(|()| fs::rename(&temporary, path));
    written.map_err(|source| {
        // The rename's failure is reported; a leftover that cannot be removed adds nothing to it.
        let _ = fs::remove_file(&temporary);
        failed(path, source)
    })
}
