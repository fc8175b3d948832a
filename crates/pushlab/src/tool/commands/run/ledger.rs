//! What made the files of a run, by which the next one knows what need not be done again.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use diagnosis::MadeFrom;
use serde::{Deserialize, Serialize};

use crate::tool::origin::{Input, TOOL};

/// What a file was made from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Record {
    /// The file's name in the folder.
    pub(super) output: String,
    /// Name and version.
    pub(super) tool: String,
    /// The command with the options that decide its result.
    pub(super) command: Vec<String>,
    pub(super) inputs: Vec<MadeFrom>,
    /// Of the file; none while it is written.
    pub(super) sha256: Option<String>,
}

impl Record {
    pub(super) fn begun(output: &str, command: Vec<String>, inputs: &[Input]) -> Self {
        let input = |input: &Input| MadeFrom {
            path: input.path.display().to_string(),
            sha256: input.sha256.clone(),
        };
        let inputs = inputs.iter().map(input).collect();
        Self { output: output.to_owned(), tool: TOOL.to_owned(), command, inputs, sha256: None }
    }

    /// Whether the same was made from the same, wherever it lay.
    fn is_as(&self, other: &Self) -> bool {
        let hashes = |record: &Self| -> Vec<String> {
            record.inputs.iter().map(|input| input.sha256.clone()).collect()
        };
        (&self.tool, &self.command) == (&other.tool, &other.command)
            && hashes(self) == hashes(other)
    }
}

/// The records of a folder.
pub(super) struct Ledger {
    path: PathBuf,
    records: Vec<Record>,
}

#[derive(Serialize, Deserialize)]
struct Document {
    schema: String,
    phases: Vec<Record>,
}

/// Name and version of the file's form.
const SCHEMA: &str = "pushlab.run-phases/1";

impl Ledger {
    /// The records that a file has; none where it is not there, or of another form.
    pub(super) fn read(path: &Path) -> Self {
        let text = std::fs::read_to_string(path).unwrap_or_default();
        let document: Option<Document> = serde_json::from_str(&text).ok();
        let document = document.filter(|document| document.schema == SCHEMA);
        let records = document.map_or_else(Vec::new, |document| document.phases);
        Self { path: path.to_owned(), records }
    }

    fn of(&self, path: &Path) -> Option<&Record> {
        let name = path.file_name()?.to_str()?;
        self.records.iter().find(|record| record.output == name)
    }

    /// Whether a file is as a run left it, or half done by one that was stopped.
    ///
    /// # Errors
    /// If it cannot be read.
    pub(super) fn is_own(&self, path: &Path) -> Result<bool> {
        let Some(record) = self.of(path) else { return Ok(false) };
        let Some(written) = &record.sha256 else { return Ok(true) };
        Ok(Input::file(path)?.sha256 == *written)
    }

    /// Whether a file is there as it would be made now.
    ///
    /// # Errors
    /// If it cannot be read.
    pub(super) fn is_done(&self, path: &Path, now: &Record) -> Result<bool> {
        let is_same =
            self.of(path).is_some_and(|record| record.sha256.is_some() && record.is_as(now));
        Ok(is_same && path.is_file() && self.is_own(path)?)
    }

    /// Notes a file that is being made, or that is made.
    ///
    /// # Errors
    /// If the records cannot be written.
    pub(super) fn note(&mut self, record: Record) -> Result<()> {
        match self.records.iter_mut().find(|known| known.output == record.output) {
            Some(known) => *known = record,
            None => self.records.push(record),
        }
        let document = Document { schema: SCHEMA.to_owned(), phases: self.records.clone() };
        let text = serde_json::to_string_pretty(&document).context("cannot write JSON")? + "\n";
        Ok(output::write(&self.path, text)?)
    }
}

#[cfg(test)]
mod tests {
    use super::{Ledger, Record};
    use crate::tool::origin::Input;

    #[test]
    fn a_file_is_done_until_it_or_what_it_was_made_from_changes() {
        let dir = tempfile::tempdir().unwrap();
        let (file, path) = (dir.path().join("model.toml"), dir.path().join("phases.json"));
        let now = |hash: &str, seed: &str| {
            let inputs = [Input::known("a.csv".as_ref(), hash.to_owned())];
            Record::begun("model.toml", vec!["fit".to_owned(), seed.to_owned()], &inputs)
        };
        let mut ledger = Ledger::read(&path);
        assert!(!ledger.is_own(&file).unwrap() && !ledger.is_done(&file, &now("1", "7")).unwrap());
        ledger.note(now("1", "7")).unwrap();
        std::fs::write(&file, "half").unwrap();
        // As a run that was stopped left it.
        assert!(ledger.is_own(&file).unwrap() && !ledger.is_done(&file, &now("1", "7")).unwrap());
        let sha256 = Some(Input::file(&file).unwrap().sha256);
        ledger.note(Record { sha256, ..now("1", "7") }).unwrap();
        let ledger = Ledger::read(&path);
        assert!(ledger.is_own(&file).unwrap() && ledger.is_done(&file, &now("1", "7")).unwrap());
        for other in [now("2", "7"), now("1", "8")] {
            assert!(!ledger.is_done(&file, &other).unwrap());
        }
        std::fs::write(&file, "by hand").unwrap();
        assert!(!ledger.is_own(&file).unwrap() && !ledger.is_done(&file, &now("1", "7")).unwrap());
        std::fs::write(&path, "{}").unwrap();
        assert!(Ledger::read(&path).records.is_empty());
    }
}
