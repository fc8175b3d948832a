//! A part of a set as `pushlab ingest --part` left it.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use dataset::IngestReport;
use serde::Deserialize;

use crate::tool::commands::ingest::report_beside;
use crate::tool::origin::{Input, TOOL};

/// A table, with what its report says.
pub(super) struct PartFile {
    pub(super) table: PathBuf,
    report_file: PathBuf,
    pub(super) report: IngestReport,
    pub(super) made_by: MadeBy,
    pub(super) warnings: Vec<String>,
}

/// What made a part.
#[derive(Deserialize)]
pub(super) struct MadeBy {
    tool: String,
    pub(super) arguments: Vec<String>,
    pub(super) inputs: Vec<Input>,
}

#[derive(Deserialize)]
struct Document {
    schema: String,
    made_by: MadeBy,
    warnings: Vec<String>,
    report: IngestReport,
}

const SCHEMA: &str = "pushlab.ingest/1";

impl PartFile {
    /// Reads the report beside a table.
    ///
    /// # Errors
    /// If it is not there, no report of an ingest, or of another release.
    pub(super) fn read(table: &Path) -> Result<Self> {
        let report_file = report_beside(table);
        let file = report_file.display();
        ensure!(
            report_file.is_file(),
            "{}: its report {file} is not beside it; `pushlab ingest --part` writes both",
            table.display()
        );
        let text =
            fs::read_to_string(&report_file).with_context(|| format!("cannot read {file}"))?;
        let found: Document = serde_json::from_str(&text)
            .with_context(|| format!("{file} is no report of `pushlab ingest --part`"))?;
        let Document { schema, made_by, warnings, report } = found;
        ensure!(schema == SCHEMA, "{file} is a `{schema}`, not a `{SCHEMA}`");
        ensure!(
            made_by.tool == TOOL,
            "{file} was made by {}, this is {TOOL}: ingest all parts by one release",
            made_by.tool
        );
        Ok(Self { table: table.to_owned(), report_file, report, made_by, warnings })
    }

    pub(super) fn paths(&self) -> [&PathBuf; 2] {
        [&self.table, &self.report_file]
    }
}
