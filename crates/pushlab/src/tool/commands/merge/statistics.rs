//! Statistics of all parts become what they say of the whole set, and a fit's next step.

use std::fmt;
use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use diagnosis::{ErrorTable, PartedEffect, PartedEstimate, PartedFit};
use gp_core::{GpError, Parts};
use models::ModelFile;
use output::OutputFile;
use serde::Serialize;

use crate::tool::commands::compare::{write_calibration, write_error};
use crate::tool::commands::statistics::{OfPart, Round, Statistics};
use crate::tool::document::document;
use crate::tool::origin::{Input, Origin};
use crate::tool::people::{behind_number, digits_of_error};
use crate::tool::terminal::{TITLE, Terminal};

/// What all parts say together.
#[derive(Serialize)]
struct Merged {
    model: PathBuf,
    n_parts: usize,
    errors: ErrorTable,
    #[serde(skip_serializing_if = "Option::is_none")]
    fit: Option<PartedFit>,
    /// For the next one.
    round: Round,
}

/// Merges the statistics of parts, one in memory at a time and those that wait for their neighbors.
///
/// - `output`: of the result, and of the fitted model.
///
/// # Errors
/// Parts that do not go together, by name; what a fit's step says; a file that cannot be written.
pub(super) fn run(
    paths: &[PathBuf],
    [output, fitted]: [Option<OutputFile>; 2],
    terminal: &Terminal,
) -> Result<()> {
    let mut origin =
        Origin::new("merge").words(paths.iter().map(|path| path.display().to_string()));
    let mut progress = terminal.progress("parts read:", paths.len());
    let mut first: Option<(&Path, OfPart)> = None;
    let mut parts: Option<Parts<Statistics>> = None;
    for path in paths {
        let found = OfPart::read(path)?;
        origin.inputs.push(Input::file(path)?);
        if let Some((own, first)) = &first {
            first.goes_with(own, (path, &found))?;
        }
        let of = found.part.of();
        let all = parts.get_or_insert_with(|| Parts::new(of as u64));
        let added = all.add(found.part.number() as u64 - 1, found.statistics.clone());
        added.map_err(|error| told(&error, of))?;
        first.get_or_insert((path, found));
        progress.advance();
    }
    progress.finish();
    let (Some((_, OfPart { part, round, .. })), Some(parts)) = (first, parts) else {
        bail!("no part is given");
    };
    let sums = parts.finish().map_err(|error| told(&error, part.of()))?;
    let errors = sums.errors.table(&round.grid);
    let (mut next, mut fit) = (round, None);
    if let (Some(place), Some(equations)) = (&next.fit, &sums.equations) {
        let (there, found) = place.step(equations)?;
        (next.fit, fit) = (Some(there), Some(found));
    }
    if let Some(output) = fitted {
        let Some(fit) = &fit else {
            bail!("these are statistics without a fit: leave out --fitted")
        };
        write_model(fit, &next, output)?;
    }
    let result =
        Merged { model: next.model.path.clone(), n_parts: part.of(), errors, fit, round: next };
    if let Some(output) = output {
        output.write(document(&origin, &terminal.warnings(), &result)?)?;
    }
    terminal.finish(&origin, &result, &result)
}

/// Writes the model at the place that the parts were summed up at.
fn write_model(fit: &PartedFit, round: &Round, output: OutputFile) -> Result<()> {
    let model = round.model()?;
    let description = fit.description(&model.description, &round.set)?;
    let (name, made_for) = (format!("{}, fitted", model.name), model.made_for);
    Ok(ModelFile { made_for, ..ModelFile::new(name, description) }.write_to(output)?)
}

/// A fault of parts in the words of the command line, which counts them from 1.
fn told(error: &GpError, of: usize) -> anyhow::Error {
    match error {
        GpError::PartTwice { part, .. } => {
            anyhow::anyhow!("part {}/{of} is given twice", part + 1)
        }
        GpError::PartMissing { part, .. } => {
            let part = part + 1;
            anyhow::anyhow!(
                "part {part}/{of} is missing: make it by `statistics --part {part}/{of}`, and name it too"
            )
        }
        other => anyhow::anyhow!("the parts do not go together: {other}"),
    }
}

impl fmt::Display for Merged {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ErrorTable { n_pushes, n_steps, n_excluded, channels, calibration, maps } =
            &self.errors;
        let (model, n_parts) = (self.model.display(), self.n_parts);
        write!(
            f,
            "{TITLE}{model}{TITLE:#} on {n_steps} steps of {n_pushes} pushes, in {n_parts} parts"
        )?;
        writeln!(f, "; {n_excluded} rows are excluded")?;
        writeln!(
            f,
            "{TITLE}error of a step, RMS{TITLE:#} (± takes whole pushes for independent, floors are the sample's)"
        )?;
        channels.iter().try_for_each(|error| write_error(f, error))?;
        write_calibration(f, calibration)?;
        writeln!(f, "  {} maps of mean residuals: --json or -o has them", maps.len())?;
        let Some(fit) = &self.fit else { return Ok(()) };
        let PartedFit { rounds, decrement, whitened_rms, is_converged, .. } = fit;
        match is_converged {
            true => writeln!(f, "{TITLE}fitted{TITLE:#} in {rounds} rounds")?,
            false => writeln!(
                f,
                "{TITLE}fit, round {rounds}{TITLE:#}: {decrement:.1e} standard errors² from the minimum by its \
                 slopes; sum the parts up once more with this as --round"
            )?,
        }
        writeln!(f, "  error over noise: {whitened_rms:.2}")?;
        fit.effects.iter().try_for_each(|effect| write_effect(f, effect))?;
        writeln!(f, "{TITLE}left open beside it{TITLE:#}, not written")?;
        fit.nuisances.iter().try_for_each(|effect| write_effect(f, effect))
    }
}

fn write_effect(f: &mut fmt::Formatter<'_>, effect: &PartedEffect) -> fmt::Result {
    for PartedEstimate { name, unit, value, se } in &effect.parameters {
        let (digits, unit) = (digits_of_error(*se), behind_number(unit));
        writeln!(f, "  {} {name}: {value:.digits$} ± {se:.digits$}{unit}", effect.id)?;
    }
    Ok(())
}
