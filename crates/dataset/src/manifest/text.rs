//! The text of a manifest, for messages with file and line.

use std::{ops::Range, path::Path};

use serde::de::DeserializeOwned;
use serde_spanned::Spanned;

use crate::error::DatasetError;

/// Positive quantities of a rig, in SI units: of a toy's moment of inertia to a truck's mass.
const SMALLEST: f64 = 1e-12;
pub(crate) const LARGEST: f64 = 1e6;
/// Rubber on rubber has about 1.2.
const LARGEST_FRICTION: f64 = 10.0;

/// The text of a manifest, for messages with file and line.
pub(crate) struct Source<'a> {
    text: &'a str,
    path: &'a Path,
}

impl<'a> Source<'a> {
    pub(crate) fn new(text: &'a str, path: &'a Path) -> Self {
        Self { text, path }
    }

    /// The text as a table of TOML.
    pub(crate) fn parse<T: DeserializeOwned>(&self) -> Result<T, DatasetError> {
        toml::from_str(self.text).map_err(|error| DatasetError::Parse {
            path: self.path.into(),
            line: error.span().map_or(0, |span| self.line(&span)),
            what: error.message().replace('\n', "; "),
        })
    }

    /// The text as a table of TOML, in which no more than one value is still open.
    ///
    /// A key that is not known is told first: it may be the one that is missing.
    pub(crate) fn parse_filled<T: DeserializeOwned>(&self) -> Result<T, DatasetError> {
        let parsed = self.parse();
        let is_unknown = |error: &DatasetError| matches!(error, DatasetError::Parse { what, .. } if what.starts_with("unknown field"));
        if !parsed.as_ref().is_err_and(is_unknown) {
            self.refuse_open_values()?;
        }
        parsed
    }

    pub(super) fn text(&self) -> &'a str {
        self.text
    }

    /// The error that a line is wrong.
    pub(super) fn fail(&self, line: u64, what: String) -> DatasetError {
        DatasetError::Parse { path: self.path.into(), line, what }
    }

    pub(super) fn line(&self, span: &Range<usize>) -> u64 {
        let before = &self.text.as_bytes()[..span.start.min(self.text.len())];
        1 + before.iter().filter(|&&byte| byte == b'\n').count() as u64
    }

    /// The error that a value is not allowed.
    pub(crate) fn refuse(
        &self,
        span: Range<usize>,
        key: &str,
        value: impl ToString,
        unit: &'static str,
        allowed: impl Into<String>,
    ) -> DatasetError {
        DatasetError::Manifest {
            path: self.path.into(),
            line: self.line(&span),
            key: key.to_owned(),
            value: value.to_string(),
            unit,
            allowed: allowed.into(),
        }
    }

    /// The error that a key is missing.
    pub(crate) fn missing(&self, span: Range<usize>, key: &str, allowed: &str) -> DatasetError {
        self.refuse(span, key, "(missing)", "", allowed)
    }

    /// A quantity in its SI unit, which is positive and none beyond a laboratory.
    pub(crate) fn positive(
        &self,
        key: &str,
        value: &Spanned<f64>,
        unit: &'static str,
    ) -> Result<f64, DatasetError> {
        let number = *value.get_ref();
        if (SMALLEST..=LARGEST).contains(&number) {
            return Ok(number);
        }
        let allowed = format!("a number from {SMALLEST:e} to {LARGEST:e}");
        Err(self.refuse(value.span(), key, number, unit, allowed))
    }

    /// A coefficient of friction.
    pub(crate) fn friction(&self, key: &str, value: &Spanned<f64>) -> Result<f64, DatasetError> {
        self.not_negative(key, value, "", LARGEST_FRICTION)
    }

    pub(crate) fn not_negative(
        &self,
        key: &str,
        value: &Spanned<f64>,
        unit: &'static str,
        largest: f64,
    ) -> Result<f64, DatasetError> {
        let number = *value.get_ref();
        if (0.0..=largest).contains(&number) {
            return Ok(number);
        }
        let allowed = format!("a number from 0 to {largest}");
        Err(self.refuse(value.span(), key, number, unit, allowed))
    }

    pub(crate) fn format(&self, format: Spanned<String>) -> Result<String, DatasetError> {
        const FORMATS: [&str; 6] = ["mcap", "csv", "mit-json", "mit-hdf5", "ros1-bag", "endpoints"];
        if FORMATS.contains(&format.get_ref().as_str()) {
            return Ok(format.into_inner());
        }
        let allowed = format!("one of {}", FORMATS.join(", "));
        Err(self.refuse(format.span(), "recordings.format", format.get_ref(), "", allowed))
    }
}
