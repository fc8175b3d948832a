//! `pushlab merge`: parts of a set that were ingested apart become one table and report.

mod part_file;

use std::path::PathBuf;

use anyhow::Result;
use dataset::{DatasetError, Provenance, Table, merge_each};

use self::part_file::PartFile;
use super::ingest::{Ingested, Outputs, PART};
use crate::tool::destination::Inputs;
use crate::tool::file_ending;
use crate::tool::origin::{Input, Origin, TOOL};
use crate::tool::recorded_steps::SET_FILES;
use crate::tool::terminal::Terminal;

/// Put the parts of a set together that were ingested apart
///
/// Takes the tables that `pushlab ingest --part` wrote, in any order, with their reports beside them. What
/// comes out is, byte for byte, what one `pushlab ingest` of the whole set writes.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// Tables of all parts
    #[arg(required = true, value_name = "PART", value_parser = file_ending::table)]
    parts: Vec<PathBuf>,
    #[command(flatten)]
    outputs: Outputs,
}

const EXAMPLES: &str = "\
Examples:
  pushlab merge part-1.parquet part-2.parquet part-3.parquet -o steps.parquet
  pushlab merge parts/*.parquet -o steps.parquet --report report.txt";

pub(crate) fn run(args: &Args, terminal: &Terminal) -> Result<()> {
    let terminal = &terminal.beside(args.outputs.paths())?;
    let parts: Vec<_> =
        args.parts.iter().map(|path| PartFile::read(path)).collect::<Result<_>>()?;
    let files = parts.iter().flat_map(PartFile::paths);
    let mut taken = args.outputs.take(&Inputs::default().with(files))?;
    taken.begin()?;
    let mut whole = Whole::default();
    let reports = parts.iter().map(|part| part.report.clone()).collect();
    let mut progress = terminal.progress("parts read:", parts.len());
    let report = merge_each(
        reports,
        |index| {
            let table = Table::read(&parts[index].table)?;
            progress.advance();
            whole.add(&parts[index], table.provenance)?;
            Ok(table.rows)
        },
        |_, rows| match taken.writer() {
            Some(writer) => rows.iter().try_for_each(|row| writer.write(row)),
            None => Ok(()),
        },
    );
    progress.finish();
    let report = report?;
    whole.warnings.iter().for_each(|text| terminal.warn(text));
    let (origin, provenance) = whole.origin_and_provenance();
    taken.finish(&origin, &provenance, &Ingested::Report(Box::new(report)), terminal)
}

/// What the whole carries beside its rows and report.
#[derive(Default)]
struct Whole {
    /// What one would have typed.
    arguments: Vec<String>,
    /// Files of the set itself, and recordings.
    inputs: [Vec<Input>; 2],
    /// Tool, set and settings.
    head: Vec<(String, String)>,
    /// Sources that are recordings.
    sources: Vec<(String, String)>,
    warnings: Vec<String>,
}

impl Whole {
    /// # Errors
    /// `Parts` for a part that was made otherwise than those before it.
    fn add(&mut self, part: &PartFile, provenance: Provenance) -> Result<(), DatasetError> {
        let is_of_set = |input: &&Input| {
            let name = input.path.file_name().and_then(|name| name.to_str());
            name.is_some_and(|name| SET_FILES.contains(&name))
        };
        let (of_set, recordings): (Vec<&Input>, Vec<_>) =
            part.made_by.inputs.iter().partition(is_of_set);
        let of_set: Vec<Input> = of_set.into_iter().cloned().collect();
        let arguments = without_part(&part.made_by.arguments);
        let is_source = |(key, _): &(String, String)| key == "source";
        let is_head = |entry: &&(String, String)| !is_source(entry) && entry.0 != "arguments";
        let head: Vec<_> = provenance.entries.iter().filter(is_head).cloned().collect();
        let is_first = self.arguments.is_empty();
        if is_first {
            (self.arguments, self.inputs[0], self.head) = (arguments, of_set, head);
        } else if (&self.arguments, &self.inputs[0], &self.head) != (&arguments, &of_set, &head) {
            let what = format!(
                "{} was made otherwise than the other parts: its arguments (`{}`) or dataset.toml differ; \
                 ingest all parts alike",
                part.table.display(),
                part.made_by.arguments.join(" ")
            );
            return Err(DatasetError::Parts { what });
        }
        let own: Vec<_> = self.inputs[0].iter().map(source).collect();
        let sources =
            provenance.entries.into_iter().filter(|entry| is_source(entry) && !own.contains(entry));
        self.sources.extend(sources);
        self.inputs[1].extend(recordings.into_iter().cloned());
        self.warnings.extend(part.warnings.iter().cloned());
        Ok(())
    }

    fn origin_and_provenance(self) -> (Origin, Provenance) {
        let [of_set, recordings] = self.inputs;
        let mut entries = self.head;
        entries.extend(self.sources);
        entries.extend(of_set.iter().map(source));
        let inputs = of_set.into_iter().chain(recordings).collect();
        let origin = Origin { command: "ingest", tool: TOOL, arguments: self.arguments, inputs };
        let mut provenance = Provenance { entries };
        origin.mark(&mut provenance);
        (origin, provenance)
    }
}

/// A file of a set as a table names it.
fn source(Input { path, sha256 }: &Input) -> (String, String) {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    ("source".to_owned(), format!("sha256 {sha256} {name}"))
}

/// Arguments without the option that makes a part.
fn without_part(arguments: &[String]) -> Vec<String> {
    let option = format!("--{PART}");
    let mut whole = arguments.to_vec();
    if let Some(at) = whole.iter().position(|word| *word == option) {
        whole.drain(at..(at + 2).min(whole.len()));
    }
    whole
}
