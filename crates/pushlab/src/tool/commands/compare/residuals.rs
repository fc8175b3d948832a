//! Every step of a comparison as a table for tools of others.

use anyhow::Result;
use dataset::{Cells, NamedColumn, Provenance, write_columns};
use diagnosis::{Observations, Predictions, residual_columns};
use models::Description;
use output::OutputFile;

use super::Part;
use crate::tool::origin::Origin;

/// The steps of all pushes with what a model says of them, and the part that their push was in.
///
/// # Errors
/// What the model refuses.
pub(super) fn of(model: &Description, all: &Observations, part: &Part) -> Result<Vec<NamedColumn>> {
    let mut columns = residual_columns(all, &Predictions::of(model, &[], all)?)?;
    let cells = Cells::Text(part.names_of_steps(all));
    columns.push(NamedColumn { name: "part".to_owned(), cells });
    Ok(columns)
}

/// Writes them with what they were made from.
///
/// # Errors
/// A file that cannot be written.
pub(super) fn write(output: OutputFile, columns: &[NamedColumn], origin: &Origin) -> Result<()> {
    let mut provenance = Provenance::default();
    provenance.push("tool", origin.tool);
    provenance.push("arguments", &origin.command_line());
    for input in &origin.inputs {
        provenance.push("source", &format!("sha256 {} {}", input.sha256, input.path.display()));
    }
    Ok(write_columns(output, columns, &provenance)?)
}
