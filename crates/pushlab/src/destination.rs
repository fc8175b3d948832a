//! A file to be written: checked before the work begins, whole or not there at its end.

use std::fs;
use std::io::ErrorKind;
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

/// A folder to be filled: new or empty, whole or not there at the end.
pub(crate) struct FolderDestination {
    path: PathBuf,
}

impl FolderDestination {
    /// Checks that a folder can be made there, so that no work is done in vain.
    ///
    /// # Errors
    /// If the path has files in it, is a file or has no name, or its own folder is missing.
    pub(crate) fn new(path: &Path) -> Result<Self> {
        ensure!(
            path.file_name().is_some(),
            "cannot write {}: the folder needs a name",
            path.display()
        );
        ensure!(
            !path.is_file(),
            "cannot write {}: it is a file; name a new folder",
            path.display()
        );
        let is_full = path.is_dir() && fs::read_dir(path)?.next().is_some();
        ensure!(
            !is_full,
            "cannot write {}: the folder is not empty; choose a new one",
            path.display()
        );
        let parent = folder_of(path);
        ensure!(
            parent.is_dir(),
            "cannot write {}: there is no folder {}; make it first",
            path.display(),
            parent.display()
        );
        Ok(Self { path: path.into() })
    }

    /// Fills a folder of a temporary name and renames it.
    ///
    /// # Errors
    /// What `fill` says, or if the system refuses.
    pub(crate) fn write(&self, fill: impl FnOnce(&Path) -> Result<()>) -> Result<()> {
        let part = self.path.with_added_extension(format!("{}.part", std::process::id()));
        let written = || -> Result<()> {
            fs::create_dir(&part)?;
            fill(&part)?;
            if self.path.is_dir() {
                fs::remove_dir(&self.path)?;
            }
            Ok(fs::rename(&part, &self.path)?)
        };
        let Err(error) = written() else { return Ok(()) };
        let error = match fs::remove_dir_all(&part) {
            Ok(()) => error,
            // There is nothing to remove where the folder itself could not be made.
            Err(cause) if cause.kind() == ErrorKind::NotFound => error,
            Err(cause) => {
                error.context(format!("{} is left over, remove it: {cause}", part.display()))
            }
        };
        Err(error).with_context(|| format!("cannot write {}", self.path.display()))
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
    use super::{Destination, FolderDestination};

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
    fn a_folder_is_filled_whole_or_not_at_all() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("out");
        let failed = FolderDestination::new(&path).unwrap().write(|folder| {
            std::fs::write(folder.join("a"), "1")?;
            anyhow::bail!("no")
        });
        assert!(failed.is_err() && std::fs::read_dir(dir.path()).unwrap().count() == 0);
        std::fs::create_dir(&path).unwrap();
        let destination = FolderDestination::new(&path).unwrap();
        destination.write(|folder| Ok(std::fs::write(folder.join("a"), "1")?)).unwrap();
        assert_eq!(std::fs::read(path.join("a")).unwrap(), b"1");
        for (place, says) in [
            (path.clone(), "not empty"),
            (path.join("a"), "it is a file"),
            (dir.path().join("none/out"), "make it first"),
            ("..".into(), "needs a name"),
        ] {
            let error = FolderDestination::new(&place).err().unwrap().to_string();
            assert!(error.contains(says), "{error}");
        }
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
