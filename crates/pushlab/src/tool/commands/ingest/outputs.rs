//! Where an ingest writes its table and its report.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use dataset::{Provenance, TableWriter};
use output::OutputFile;

use super::Ingested;
use crate::tool::destination::{Force, Inputs};
use crate::tool::document::document;
use crate::tool::file_ending;
use crate::tool::origin::Origin;
use crate::tool::terminal::{TITLE, Terminal};
use crate::tool::wrong_usage::WrongUsage;

/// What there is to write, and where.
#[derive(Clone, clap::Args)]
pub(in crate::tool::commands) struct Outputs {
    /// Where to write the step table: .csv or .parquet; `-` is standard output, as CSV
    #[arg(short, long, value_name = "TABLE",
          value_parser = file_ending::or_standard(file_ending::table))]
    output: Option<PathBuf>,
    /// Where to write the full report: .txt for people, .json for programs; `-` is standard output
    #[arg(long, value_name = "REPORT",
          value_parser = file_ending::or_standard(file_ending::report))]
    report: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
}

/// The same once their places are taken.
pub(in crate::tool::commands) struct Taken<'a> {
    outputs: &'a Outputs,
    table: Option<OutputFile>,
    writer: Option<TableWriter>,
    report: Option<OutputFile>,
}

impl Outputs {
    pub(in crate::tool::commands) fn new(
        output: Option<PathBuf>,
        report: Option<PathBuf>,
        force: Force,
    ) -> Self {
        Self { output, report, force }
    }

    /// Those of a part, whose report lies beside its table.
    ///
    /// # Errors
    /// If the table has no place, or the report another one.
    pub(super) fn of_part(&self) -> Result<Self> {
        let table = self.output.as_deref().filter(|table| !file_ending::is_standard(table));
        let Some(table) = table else {
            bail!(WrongUsage("a part needs a file of its own: name it by -o"));
        };
        let report = report_beside(table);
        if self.report.as_ref().is_some_and(|asked| *asked != report) {
            bail!(WrongUsage(
                "the report of a part lies beside its table, as .json: leave out --report"
            ));
        }
        Ok(Self { report: Some(report), ..self.clone() })
    }

    /// The paths that are named.
    pub(in crate::tool::commands) fn paths(&self) -> impl Iterator<Item = &Path> {
        self.output.iter().chain(&self.report).map(PathBuf::as_path)
    }

    /// Takes their places.
    ///
    /// # Errors
    /// As [`Force::file`].
    pub(in crate::tool::commands) fn take(&self, inputs: &Inputs) -> Result<Taken<'_>> {
        let take = |path: &Option<PathBuf>| {
            path.as_ref().map(|path| self.force.file(path, inputs)).transpose()
        };
        let (table, report) = (take(&self.output)?, take(&self.report)?);
        Ok(Taken { outputs: self, table, writer: None, report })
    }
}

impl Taken<'_> {
    /// Begins the table.
    ///
    /// # Errors
    /// If it cannot be written.
    pub(in crate::tool::commands) fn begin(&mut self) -> Result<()> {
        self.writer = self.table.take().map(TableWriter::begin).transpose()?;
        Ok(())
    }

    /// The table, if one was asked for and has begun.
    pub(in crate::tool::commands) fn writer(&mut self) -> Option<&mut TableWriter> {
        self.writer.as_mut()
    }

    /// Writes the report, ends the table and tells the result.
    ///
    /// # Errors
    /// If one of them cannot be written.
    pub(in crate::tool::commands) fn finish(
        self,
        origin: &Origin,
        provenance: &Provenance,
        result: &Ingested,
        terminal: &Terminal,
    ) -> Result<()> {
        if let Some(destination) = self.report {
            let is_json = destination.path().extension().is_some_and(|ending| ending == "json");
            let text = if is_json {
                document(origin, &terminal.warnings(), result)?
            } else {
                anstream::adapter::strip_str(&(result.full_text() + &origin.comment())).to_string()
            };
            destination.write(text)?;
        }
        if let Some(writer) = self.writer {
            writer.finish(provenance)?;
        }
        let mut text = result.short_text();
        for path in self.outputs.paths() {
            let _ = writeln!(text, "{TITLE}wrote {}{TITLE:#}", path.display());
        }
        terminal.finish(origin, result, text)
    }
}

/// Where the report of a part is, beside its table.
pub(in crate::tool::commands) fn report_beside(table: &Path) -> PathBuf {
    table.with_extension("json")
}
