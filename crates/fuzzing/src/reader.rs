//! What is fuzzed: a public reader with small valid inputs, and what it may do with damaged ones.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result};

/// Separates the files of an input that is more than one.
pub(super) const NEXT_FILE: u8 = 0x1e;

/// A public reader of files.
pub(super) trait Reader: Sync {
    /// Its name on the command line, and its folder below `fixtures/fuzz`.
    fn name(&self) -> &'static str;

    /// Small valid inputs, the same at every call; `dir` is empty and may be written to.
    ///
    /// # Errors
    /// When one of them cannot be made.
    fn corpus(&self, dir: &Path) -> Result<Vec<Vec<u8>>>;

    /// Words of the format, to be put into an input.
    fn tokens(&self) -> &'static [&'static str] {
        &[]
    }

    /// Reads an input as files of `dir`, which it may overwrite.
    fn read(&self, dir: &Path, input: &[u8]) -> Verdict;
}

/// What a reader made of an input.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Verdict {
    /// Values that the format allows.
    Accepted,
    /// An error that says why.
    Refused,
    /// Values that the format forbids, such as a coordinate that is not finite.
    Wrong(String),
}

impl Verdict {
    /// Accepted if nothing is wrong with what was read.
    pub(super) fn of<T, E>(read: Result<T, E>, wrong: impl FnOnce(&T) -> Option<String>) -> Self {
        match read {
            Ok(value) => wrong(&value).map_or(Self::Accepted, Self::Wrong),
            Err(_) => Self::Refused,
        }
    }
}

/// Names the first number that is not finite.
pub(super) fn not_finite<'a>(
    numbers: impl IntoIterator<Item = (&'static str, &'a [f64])>,
) -> Option<String> {
    let first = |(name, values): (&'static str, &[f64])| {
        let at = values.iter().position(|value| !value.is_finite())?;
        Some(format!("{name} is {} at {at}", values[at]))
    };
    numbers.into_iter().find_map(first)
}

/// Writes the files of an input, in order; those that it has no bytes for are empty.
pub(super) fn write_files(dir: &Path, names: &[&str], input: &[u8]) -> std::io::Result<()> {
    let mut parts = input.splitn(names.len(), |byte| *byte == NEXT_FILE);
    names.iter().try_for_each(|name| fs::write(dir.join(name), parts.next().unwrap_or_default()))
}

/// The files of a folder as one input.
pub(super) fn join_files(dir: &Path, names: &[&str]) -> Result<Vec<u8>> {
    let read =
        |name: &&str| fs::read(dir.join(name)).with_context(|| format!("cannot read {name}"));
    Ok(names.iter().map(read).collect::<Result<Vec<_>>>()?.join(&NEXT_FILE))
}

#[cfg(test)]
mod tests {
    use super::{join_files, not_finite, write_files};

    #[test]
    fn files_of_an_input_come_back_as_they_were() {
        let dir = tempfile::tempdir().unwrap();
        let names = ["a", "b", "c"];
        write_files(dir.path(), &names, b"one\x1etwo").unwrap();
        assert_eq!(std::fs::read(dir.path().join("b")).unwrap(), b"two");
        assert_eq!(join_files(dir.path(), &names).unwrap(), b"one\x1etwo\x1e");
    }

    #[test]
    fn the_first_number_that_is_not_finite_is_named() {
        assert_eq!(not_finite([("t", &[0.0, 1.0][..])]), None);
        let found = not_finite([("t", &[0.0][..]), ("x", &[0.0, f64::NAN][..])]);
        assert_eq!(found.as_deref(), Some("x is NaN at 1"));
    }
}
