//! An object as people name it.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use anyhow::Result;
use planar::MIT_NAMES;
use plant::{Nominal, PushedObject, read_rig};

use crate::tool::origin::readable;

/// The object from the command line, and the rig that it is pushed on.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum ShapeName {
    /// One of the MIT push data set's, on its rig.
    Mit(String),
    /// That of a manifest, or of a folder with one.
    Manifest(PathBuf),
}

impl ShapeName {
    /// The object, and what a manifest claims of its rig, where there is one.
    ///
    /// # Errors
    /// A manifest that cannot be read or is wrong.
    pub(super) fn rig(&self) -> Result<(PushedObject, Option<Nominal>)> {
        match self {
            Self::Mit(name) => Ok((PushedObject::Mit { name: name.clone() }, None)),
            Self::Manifest(path) => {
                readable(path)?;
                let (object, nominal) = read_rig(path)?;
                Ok((object, Some(nominal)))
            }
        }
    }

    /// The manifest, where there is one.
    pub(super) fn manifest(&self) -> Option<PathBuf> {
        match self {
            Self::Mit(_) => None,
            Self::Manifest(path) if path.is_dir() => Some(path.join(dataset::MANIFEST_NAME)),
            Self::Manifest(path) => Some(path.clone()),
        }
    }
}

impl FromStr for ShapeName {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if MIT_NAMES.contains(&text) {
            return Ok(Self::Mit(text.to_owned()));
        }
        if text.ends_with(".toml") || text.contains(['/', std::path::MAIN_SEPARATOR]) {
            return Ok(Self::Manifest(text.into()));
        }
        Err(format!("expected {}, or a dataset.toml with an object", MIT_NAMES.join(", ")))
    }
}

impl fmt::Display for ShapeName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Mit(name) => f.write_str(name),
            Self::Manifest(path) => write!(f, "{}", path.display()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::ShapeName;

    #[test]
    fn names_files_and_folders_are_told_apart() {
        assert_eq!("rect1".parse(), Ok(ShapeName::Mit("rect1".into())));
        assert_eq!("a.toml".parse(), Ok(ShapeName::Manifest("a.toml".into())));
        assert_eq!("./set".parse(), Ok(ShapeName::Manifest("./set".into())));
        assert!("rect9".parse::<ShapeName>().unwrap_err().contains("butter, or a dataset.toml"));
    }
}
