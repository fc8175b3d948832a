//! A file to be written: checked before the work begins, whole or not there at its end.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};

/// A path at which a file can be written.
pub(crate) struct Destination {
    path: PathBuf,
}

impl Destination {
    /// Checks that the file's folder is there, so that no work is done in vain.
    ///
    /// # Errors
    /// If the folder is missing, or the path is a folder.
    pub(crate) fn new(path: &Path) -> Result<Self> {
        ensure!(!path.is_dir(), "cannot write {}: it is a folder; name a file", path.display());
        let folder = folder_of(path);
        if !folder.is_dir() {
            bail!(
                "cannot write {}: there is no folder {}; make it first",
                path.display(),
                folder.display()
            );
        }
        Ok(Self { path: path.into() })
    }

    /// The same, and refuses a file that is there.
    ///
    /// # Errors
    /// Also if the path exists.
    pub(crate) fn unused(path: &Path) -> Result<Self> {
        ensure!(!path.exists(), "{} exists; remove or rename it first", path.display());
        Self::new(path)
    }

    /// The path.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Makes sure that no input is overwritten, nor a file put into a recording.
    ///
    /// # Errors
    /// If the path is an input, or lies in one.
    pub(crate) fn spare(&self, inputs: &[PathBuf]) -> Result<()> {
        let Ok(folder) = folder_of(&self.path).canonicalize() else { return Ok(()) };
        let own = folder.join(self.path.file_name().unwrap_or_default());
        for input in inputs {
            let is_input = input.canonicalize().is_ok_and(|path| own.starts_with(path));
            ensure!(
                !is_input,
                "cannot write {}: it belongs to the input {}; name another file",
                self.path.display(),
                input.display()
            );
        }
        Ok(())
    }

    /// Writes the file under a temporary name and renames it.
    ///
    /// # Errors
    /// If the system refuses.
    pub(crate) fn write(&self, bytes: &[u8]) -> Result<()> {
        let part = self.path.with_added_extension("part");
        let written = fs::write(&part, bytes).and_then(|()| fs::rename(&part, &self.path));
        if written.is_err() {
            let _ = fs::remove_file(&part);
        }
        written.with_context(|| format!("cannot write {}", self.path.display()))
    }
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    }
}

#[cfg(test)]
mod tests {
    use super::Destination;

    #[test]
    fn a_file_is_written_whole_and_leaves_nothing_beside_it() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.txt");
        let destination = Destination::new(&path).unwrap();
        destination.write(b"first").unwrap();
        destination.write(b"second").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"second");
        assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 1);
        assert!(Destination::unused(&path).is_err());
        assert!(Destination::new(dir.path()).is_err());
        assert!(Destination::new(&dir.path().join("none/a.txt")).is_err());
    }

    #[test]
    fn inputs_are_spared() {
        let dir = tempfile::tempdir().unwrap();
        let recording = dir.path().join("push-0");
        std::fs::create_dir(&recording).unwrap();
        let inside = Destination::new(&recording.join("../push-0/steps.csv")).unwrap();
        assert!(inside.spare(std::slice::from_ref(&recording)).is_err());
        let beside = Destination::new(&dir.path().join("push-0.csv")).unwrap();
        beside.spare(&[recording]).unwrap();
    }
}
