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

/// Writes a whole file into a folder, which is made where it is missing.
pub(crate) fn write(path: &Path, bytes: impl AsRef<[u8]>) -> Result<(), ReportError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    if !folder.as_os_str().is_empty() {
        let made = fs::create_dir_all(folder);
        made.map_err(|source| ReportError::Write { path: folder.to_owned(), source })?;
    }
    Ok(output::write(path, bytes)?)
}
