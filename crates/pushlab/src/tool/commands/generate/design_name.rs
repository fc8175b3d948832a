//! A design of pushes as people name it.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use anyhow::Result;
use plant::{Layout, read_push_list};

use crate::tool::origin::readable;

/// A design from the command line.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum DesignName {
    /// Any place, angle and orientation.
    Random,
    /// The thesis' grid.
    Thesis,
    /// One edge and one orientation.
    Narrow,
    /// A few pushes over and over.
    Repeats,
    /// The pushes of a file.
    File(PathBuf),
}

impl DesignName {
    /// The layout that it stands for.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub(super) fn layout(&self) -> Result<Layout> {
        Ok(match self {
            Self::Random => Layout::Rich,
            Self::Thesis => Layout::Thesis,
            Self::Narrow => Layout::Narrow { edge: 0 },
            Self::Repeats => Layout::Repeats,
            Self::File(path) => {
                readable(path)?;
                Layout::List(read_push_list(path)?)
            }
        })
    }
}

impl FromStr for DesignName {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Ok(match text {
            "random" => Self::Random,
            "thesis" => Self::Thesis,
            "narrow" => Self::Narrow,
            "repeats" => Self::Repeats,
            file if file.ends_with(".csv") => Self::File(file.into()),
            _ => return Err("expected random, thesis, narrow, repeats or a FILE.csv".to_owned()),
        })
    }
}

impl fmt::Display for DesignName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Random => f.write_str("random"),
            Self::Thesis => f.write_str("thesis"),
            Self::Narrow => f.write_str("narrow"),
            Self::Repeats => f.write_str("repeats"),
            Self::File(path) => write!(f, "{}", path.display()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::DesignName;

    #[test]
    fn names_are_read_as_they_are_written() {
        for text in ["random", "thesis", "narrow", "repeats", "a/pushes.csv"] {
            assert_eq!(text.parse::<DesignName>().unwrap().to_string(), text);
        }
        let error = "grid".parse::<DesignName>().unwrap_err();
        assert_eq!(error, "expected random, thesis, narrow, repeats or a FILE.csv");
    }
}
