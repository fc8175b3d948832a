//! Every step of a comparison as a table for tools of others.

use anyhow::Result;
use dataset::{Cells, NamedColumn, Provenance, write_columns};
use diagnosis::{Observations, Predictions, residual_columns};
use models::Description;
use output::OutputFile;

use super::Part;
use crate::origin::Origin;

/// Place of the column that tells a push's part, behind those that name the step.
const PART: usize = 3;

/// The steps with what a model says of them.
///
/// # Errors
/// What the model refuses.
pub(super) fn of(model: &Description, all: &Observations) -> Result<Vec<NamedColumn>> {
    Ok(residual_columns(all, &Predictions::of(model, &[], all)?)?)
}

/// Writes them with the part of each push.
///
/// # Errors
/// A file that cannot be written.
pub(super) fn write(
    output: OutputFile,
    mut steps: Vec<NamedColumn>,
    part: &Part,
    origin: &Origin,
) -> Result<()> {
    let parts = pushes(&steps).map(|push| part.name_of(&push).to_owned()).collect();
    steps.insert(PART, NamedColumn { name: "part".to_owned(), cells: Cells::Text(parts) });
    let mut provenance = Provenance::default();
    provenance.push("tool", origin.tool);
    provenance.push("arguments", &origin.command_line());
    for input in &origin.inputs {
        provenance.push("source", &format!("sha256 {} {}", input.sha256, input.path.display()));
    }
    Ok(write_columns(output, &steps, &provenance)?)
}

/// The push of each row, as splits name it.
fn pushes(columns: &[NamedColumn]) -> impl Iterator<Item = String> {
    let (recordings, numbers) = match columns {
        [
            NamedColumn { cells: Cells::Text(recordings), .. },
            NamedColumn { cells: Cells::Integer(numbers), .. },
            ..,
        ] => (recordings.clone(), numbers.clone()),
        _ => (Vec::new(), Vec::new()),
    };
    recordings.into_iter().zip(numbers).map(|(recording, push)| format!("{recording}#{push}"))
}
