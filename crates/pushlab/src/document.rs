//! A command's result for programs.

use anyhow::{Context, Result};
use serde::Serialize;

use crate::origin::Origin;

/// A result with what made it, as `--json` prints it and reports in JSON hold it.
pub(crate) struct Document<'a, R> {
    pub(crate) origin: &'a Origin,
    pub(crate) result: &'a R,
}

#[derive(Serialize)]
struct Fields<'a, R> {
    schema: &'static str,
    #[serde(flatten)]
    origin: &'a Origin,
    result: &'a R,
}

impl<R: Serialize> Document<'_, R> {
    /// Version of the document's form.
    const SCHEMA: &'static str = "pushlab.result/1";

    /// The document as indented JSON with a line break at its end.
    ///
    /// # Errors
    /// If the result cannot be written as JSON.
    pub(crate) fn to_json(&self) -> Result<String> {
        let fields = Fields { schema: Self::SCHEMA, origin: self.origin, result: self.result };
        let text = serde_json::to_string_pretty(&fields).context("cannot write JSON")?;
        Ok(text + "\n")
    }
}
