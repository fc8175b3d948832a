//! `pushlab merge`: parts of a set become one: tables with their reports, or statistics.

mod part_file;
mod statistics;

use std::path::PathBuf;

use anyhow::{Result, bail};
use dataset::{DatasetError, Provenance, Table, merge_each};

use self::part_file::PartFile;
use super::ingest::{Ingested, Outputs, PART};
use crate::tool::destination::{Force, Inputs};
use crate::tool::file_ending;
use crate::tool::origin::{Input, Origin, TOOL};
use crate::tool::recorded_steps::SET_FILES;
use crate::tool::terminal::Terminal;
use crate::tool::wrong_usage::WrongUsage;

/// Put the parts of a set together that were ingested, or summed up, apart
///
/// Takes the tables that `pushlab ingest --part` wrote, in any order, with their reports beside them. What
/// comes out is, byte for byte, what one `pushlab ingest` of the whole set writes. Or takes what `pushlab
/// statistics --part` wrote, in any order, and tells how wrong the model is on the whole set and where, and of a
/// fit where it stands; what comes out does not depend on the order to the last bit.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// Tables of all parts (.csv, .parquet), or their statistics (.json)
    #[arg(required = true, value_name = "PART", value_parser = file_ending::json_or_table)]
    parts: Vec<PathBuf>,
    /// Where to write the step table: .csv or .parquet; or of statistics what they say, .json, from which the
    /// next round begins; `-` is standard output
    #[arg(short, long, value_name = "FILE",
          value_parser = file_ending::or_standard(file_ending::json_or_table))]
    output: Option<PathBuf>,
    /// Of tables: where to write the full report: .txt for people, .json for programs; `-` is standard output
    #[arg(long, value_name = "REPORT",
          value_parser = file_ending::or_standard(file_ending::report))]
    report: Option<PathBuf>,
    /// Of statistics with a fit: where to write the model as fitted so far
    #[arg(long, value_name = "FILE",
          value_parser = file_ending::or_standard(file_ending::model))]
    fitted: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
}

const EXAMPLES: &str = "\
Examples:
  pushlab merge part-1.parquet part-2.parquet part-3.parquet -o steps.parquet
  pushlab merge parts/*.parquet -o steps.parquet --report report.txt
  pushlab merge parts/*.json -o round-1.json
  pushlab merge parts/*.json --fitted fitted.toml";

pub(crate) fn run(args: &Args, terminal: &Terminal) -> Result<()> {
    let is_json = |path: &PathBuf| path.extension().is_some_and(|ending| ending == "json");
    let n_json = args.parts.iter().filter(|path| is_json(path)).count();
    if n_json > 0 && n_json < args.parts.len() {
        bail!(WrongUsage("tables and statistics do not go together; merge each kind alone"));
    }
    let is_of_kind =
        |path: &PathBuf| file_ending::is_standard(path) || is_json(path) == (n_json > 0);
    if !args.output.as_ref().is_none_or(is_of_kind) {
        bail!(WrongUsage(
            "tables become a table (.csv, .parquet), statistics what they say (.json)"
        ));
    }
    match n_json {
        0 if args.fitted.is_some() => bail!(WrongUsage("--fitted is for statistics with a fit")),
        0 => tables(args, terminal),
        _ if args.report.is_some() => {
            bail!(WrongUsage("--report is for tables; -o has all of statistics"))
        }
        _ => {
            let terminal =
                &terminal.beside(args.output.iter().chain(&args.fitted).map(PathBuf::as_path))?;
            let inputs = Inputs::default().with(&args.parts);
            let take = |path: &Option<PathBuf>| {
                path.as_ref().map(|path| args.force.file(path, &inputs)).transpose()
            };
            statistics::run(&args.parts, [take(&args.output)?, take(&args.fitted)?], terminal)
        }
    }
}

fn tables(args: &Args, terminal: &Terminal) -> Result<()> {
    let Args { output, report, force, .. } = args;
    let outputs = Outputs::new(output.clone(), report.clone(), force.clone());
    let terminal = &terminal.beside(outputs.paths())?;
    let parts: Vec<_> =
        args.parts.iter().map(|path| PartFile::read(path)).collect::<Result<_>>()?;
    let files = parts.iter().flat_map(PartFile::paths);
    let mut taken = outputs.take(&Inputs::default().with(files))?;
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
