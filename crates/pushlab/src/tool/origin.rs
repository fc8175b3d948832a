//! What made an output: the tool, the arguments that decide it, the inputs by their hashes.

use std::fs::{self, Metadata};
use std::io;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use dataset::{Provenance, ReadLimits, open_regular};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

/// The tool's name and version.
pub(crate) const TOOL: &str = concat!("pushlab ", env!("CARGO_PKG_VERSION"));

/// What every output carries.
#[derive(Serialize)]
pub(crate) struct Origin {
    /// The command's name.
    #[serde(skip)]
    pub(crate) command: &'static str,
    /// Name and version.
    pub(crate) tool: &'static str,
    /// The command and what decides its result; paths of outputs, threads and colors do not.
    pub(crate) arguments: Vec<String>,
    /// What was read.
    pub(crate) inputs: Vec<Input>,
}

/// A file, or a folder that is one recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Input {
    /// Where it was read.
    pub(crate) path: PathBuf,
    /// In lower-case hexadecimal digits.
    pub(crate) sha256: String,
}

impl Origin {
    /// Of a command, whose arguments are to be added in the order in which one would type them.
    pub(crate) fn new(command: &'static str) -> Self {
        let arguments = command.split_whitespace().map(str::to_owned).collect();
        Self { command, tool: TOOL, arguments, inputs: Vec::new() }
    }

    /// The same with more words.
    pub(crate) fn words(mut self, words: impl IntoIterator<Item = String>) -> Self {
        self.arguments.extend(words);
        self
    }

    /// The same with a path.
    pub(crate) fn path(self, path: &Path) -> Self {
        self.words([path.display().to_string()])
    }

    /// The same with an option, once for each of its values.
    pub(crate) fn option<V: ToString>(
        self,
        name: &str,
        values: impl IntoIterator<Item = V>,
    ) -> Self {
        let pairs = values.into_iter().map(|value| [format!("--{name}"), value.to_string()]);
        self.words(pairs.flatten())
    }

    /// The same with an option whose values are paths.
    pub(crate) fn paths<'a>(
        self,
        name: &str,
        paths: impl IntoIterator<Item = &'a PathBuf>,
    ) -> Self {
        self.option(name, paths.into_iter().map(|path| path.display()))
    }

    /// The same as comment lines, for files that have comments.
    pub(crate) fn comment(&self) -> String {
        let mut text = format!("# tool: {}\n# arguments: {}\n", self.tool, self.command_line());
        for Input { path, sha256 } in &self.inputs {
            text += &format!("# source: sha256 {sha256} {}\n", path.display());
        }
        text
    }

    /// Adds the arguments to a table's provenance.
    pub(crate) fn mark(&self, provenance: &mut Provenance) {
        provenance.push("arguments", &self.command_line());
    }

    /// The arguments as one would type them.
    pub(crate) fn command_line(&self) -> String {
        let quoted = |word: &String| {
            if word.contains(|c: char| c.is_whitespace() || c.is_control()) {
                format!("{word:?}")
            } else {
                word.clone()
            }
        };
        self.arguments.iter().map(quoted).collect::<Vec<_>>().join(" ")
    }
}

/// Checks that a path is a file or a folder: reading a device or a pipe may never end.
///
/// # Errors
/// If it is neither, or not there.
pub(crate) fn readable(path: &Path) -> Result<Metadata> {
    let metadata = fs::metadata(path).with_context(|| format!("cannot read {}", path.display()))?;
    let is_known = metadata.is_file() || metadata.is_dir();
    ensure!(is_known, "cannot read {}: it is neither a file nor a folder", path.display());
    Ok(metadata)
}

/// The path without the components that say nothing, such as in `pushes/./a.mcap`.
pub(crate) fn plain(path: &Path) -> PathBuf {
    path.components().collect()
}

impl Input {
    /// An input whose hash is known.
    pub(crate) fn known(path: &Path, sha256: String) -> Self {
        Self { path: plain(path), sha256 }
    }

    /// Hashes a file.
    ///
    /// # Errors
    /// If it cannot be read.
    pub(crate) fn file(path: &Path) -> Result<Self> {
        let mut hash = Sha256::new();
        let (mut file, _) = open_regular(path, &ReadLimits::default())?;
        io::copy(&mut file, &mut hash)
            .with_context(|| format!("cannot read {}", path.display()))?;
        Ok(Self::known(path, format!("{:x}", hash.finalize())))
    }

    /// Hashes a file, or every file of a folder in the order of their names.
    ///
    /// # Errors
    /// If one of them cannot be read.
    pub(crate) fn all(path: &Path) -> Result<Vec<Self>> {
        if !path.is_dir() {
            return Ok(vec![Self::file(path)?]);
        }
        let entries = fs::read_dir(path).with_context(|| format!("cannot read {}", path.display()));
        let mut files: Vec<_> =
            entries?.filter_map(|entry| Some(entry.ok()?.path())).filter(|p| p.is_file()).collect();
        files.sort();
        files.iter().map(|file| Self::file(file)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::{Input, Origin};

    #[test]
    fn comments_name_tool_arguments_and_sources() {
        let dir = tempfile::tempdir().unwrap();
        std::fs::write(dir.path().join("a b.txt"), "abc").unwrap();
        let mut origin = Origin::new("describe").path("a b.txt".as_ref());
        origin.inputs = Input::all(dir.path()).unwrap();
        origin.inputs[0].path = "a b.txt".into();
        let version = env!("CARGO_PKG_VERSION");
        // The hash of `abc` in FIPS 180-2.
        assert_eq!(
            origin.comment(),
            format!(
                "# tool: pushlab {version}\n# arguments: describe \"a b.txt\"\n# source: sha256 \
                 ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad a b.txt\n"
            )
        );
    }
}
