//! A command's result for programs.

use anyhow::{Context, Result};
use serde::Serialize;

use crate::tool::origin::Origin;

/// The one form of every document; the fields of the result stand beside these.
///
/// `diagnosis.json` has the same, and is read again: the crate `diagnosis` defines it.
#[derive(Serialize)]
struct Document<'a, R> {
    /// Name and version of the fields.
    schema: String,
    made_by: &'a Origin,
    /// What people were told beside the result.
    warnings: &'a [String],
    #[serde(flatten)]
    result: &'a R,
}

/// A result as `--json` prints it and files in JSON hold it, with a line break at its end.
///
/// # Errors
/// If the result cannot be written as JSON.
pub(crate) fn document<R: Serialize>(
    origin: &Origin,
    warnings: &[String],
    result: &R,
) -> Result<String> {
    let schema = format!("pushlab.{}/1", origin.command.replace(' ', "-"));
    indented(&Document { schema, made_by: origin, warnings, result })
}

/// A document that has its form already.
///
/// # Errors
/// If it cannot be written as JSON.
pub(crate) fn indented(document: &impl Serialize) -> Result<String> {
    Ok(serde_json::to_string_pretty(document).context("cannot write JSON")? + "\n")
}
