//! `pushlab ingest`: recordings, or a table of others, become a step table.

mod ingested;
mod outputs;
mod source;

use std::path::PathBuf;

use anyhow::{Result, bail};
use clap::ValueEnum;
use clap::builder::PossibleValuesParser;
use dataset::{
    Curve, EndCondition, IngestSettings, Part, Preset, Provenance, RecordingSet, Table,
    TableWriter, ingest_each, provenance,
};

use planar::MIT_NAMES;

pub(super) use self::ingested::Ingested;
pub(super) use self::outputs::{Outputs, report_beside};
use self::source::Source;
use crate::tool::command_line::preset_parser;
use crate::tool::destination::Inputs;
use crate::tool::origin::{Input, Origin};
use crate::tool::recorded_steps::recorded_inputs;
use crate::tool::step_size::StepSize;
use crate::tool::suspected::{suspected, warn};
use crate::tool::table_summary::TableSummary;
use crate::tool::terminal::Terminal;
use crate::tool::wrong_usage::WrongUsage;

/// Turn recordings into a step table, with a report of every repair
///
/// Takes a recording set: a folder with dataset.toml, the manifest itself, or a folder that a preset
/// knows. A step table of others (.csv) is converted by a mapping of its columns. Without -o nothing
/// but the summary is made.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// Recording set, or a foreign step table
    set: PathBuf,
    #[command(flatten)]
    outputs: Outputs,
    /// Length of a step: a time (200ms, 0.2s) or a way of the pusher (4mm, 0.4cm); else 200ms
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true)]
    step: Option<StepSize>,
    /// The curve through the samples of a pose stream; else interpolate
    #[arg(long)]
    curve: Option<CurveName>,
    /// Take what is known of a public data set, whatever dataset.toml says
    #[arg(long, value_name = "NAME", value_parser = preset_parser())]
    preset: Option<Preset>,
    /// Of public data about several shapes, the pushes of this one alone
    #[arg(long, value_name = "NAME", value_parser = PossibleValuesParser::new(MIT_NAMES),
          requires = "preset")]
    shape: Option<String>,
    /// How the columns of a foreign step table become ours (see `init . --preset mit-table -o -`)
    #[arg(long, value_name = "FILE", conflicts_with_all = ["preset", "step", "curve"])]
    mapping: Option<PathBuf>,
    /// Read one of so many parts of the recordings; `pushlab merge` puts parts together. The report of a part
    /// goes beside its table, as .json
    #[arg(long, value_name = "I/N", requires = "output", conflicts_with = "mapping")]
    part: Option<Part>,
}

const EXAMPLES: &str = "\
Examples:
  pushlab ingest pushes -o steps.csv
  pushlab ingest pushes -o steps.parquet --step 4mm --report report.txt
  pushlab ingest mit-push-table/table.csv --preset mit-table -o steps.csv
  pushlab ingest plywood.csv --preset mit-endpoints --shape hex -o hex.csv
  pushlab ingest pushes --part 3/8 -o part-3.parquet     # on one of eight machines; then `merge`";

/// The option that makes a part, which is not of the whole.
pub(super) const PART: &str = "part";

#[derive(Clone, Copy, ValueEnum)]
enum CurveName {
    /// A cubic spline through every sample
    Interpolate,
    /// A smoothing spline with the noise that each push shows
    Smooth,
}

pub(crate) fn run(args: &Args, terminal: &Terminal) -> Result<()> {
    let outputs = match args.part {
        Some(_) => args.outputs.of_part()?,
        None => args.outputs.clone(),
    };
    let terminal = &terminal.beside(outputs.paths())?;
    let inputs = Inputs::default().with_set(&args.set, args.preset).with(&args.mapping);
    let mut taken = outputs.take(&inputs)?;
    let source = Source::of(args)?;
    taken.begin()?;
    let (provenance, origin, result) = match source {
        Source::Recordings(set) => args.ingest(*set, taken.writer(), terminal)?,
        Source::Table { table, inputs } => args.convert(*table, inputs, taken.writer())?,
    };
    taken.finish(&origin, &provenance, &result, terminal)
}

impl Args {
    /// Refuses what is for recordings alone.
    fn refuse_step(&self) -> Result<()> {
        if self.step.is_some() || self.curve.is_some() {
            bail!(WrongUsage("a table has its steps already: leave out --step and --curve"));
        }
        if self.part.is_some() {
            bail!(WrongUsage("a table is converted at once: leave out --part"));
        }
        Ok(())
    }

    fn convert(
        &self,
        mut table: Table,
        inputs: Vec<Input>,
        writer: Option<&mut TableWriter>,
    ) -> Result<(Provenance, Origin, Ingested)> {
        self.refuse_step()?;
        for Input { path, sha256 } in inputs.iter().skip(1) {
            let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
            table.provenance.push("source", &format!("sha256 {sha256} {name}"));
        }
        let mut origin = self.origin();
        origin.inputs = inputs;
        origin.mark(&mut table.provenance);
        let summary = TableSummary::of(&table);
        if let Some(writer) = writer {
            table.rows.iter().try_for_each(|row| writer.write(row))?;
        }
        Ok((table.provenance, origin, Ingested::Table(Box::new(summary))))
    }

    /// Rows go to the file as they come: memory does not grow with their number.
    fn ingest(
        &self,
        set: RecordingSet,
        mut writer: Option<&mut TableWriter>,
        terminal: &Terminal,
    ) -> Result<(Provenance, Origin, Ingested)> {
        if set.is_of_end_points() && (self.step.is_some() || self.curve.is_some()) {
            bail!(WrongUsage(
                "a push of which the ends are known is one step: leave out --step and --curve"
            ));
        }
        // What is to be told of the whole set is told once.
        if self.part.is_none_or(|part| part.number() == 1) {
            warn(&suspected(&set), terminal);
        }
        let set = &match self.part {
            Some(part) => set.in_part(part),
            None => set,
        };
        let mut settings = IngestSettings::default();
        if let Some(StepSize(step)) = self.step {
            settings.step = step;
        }
        settings.curve = match self.curve {
            None => settings.curve,
            Some(CurveName::Interpolate) => Curve::Interpolate(EndCondition::Natural),
            Some(CurveName::Smooth) => Curve::Smooth,
        };
        let mut progress = terminal.progress("recordings read:", set.recordings().len());
        let report = ingest_each(set, &settings, |_, rows| {
            progress.advance();
            match &mut writer {
                Some(writer) => rows.iter().try_for_each(|row| writer.write(row)),
                None => Ok(()),
            }
        });
        progress.finish();
        let report = report?;
        let mut origin = self.origin();
        let mut provenance = provenance(set, &report);
        origin.inputs = recorded_inputs(set, &report, &mut provenance)?;
        origin.mark(&mut provenance);
        Ok((provenance, origin, Ingested::Report(Box::new(report))))
    }

    /// What decides the result, with the defaults written out.
    fn origin(&self) -> Origin {
        let curve = self.curve.and_then(|curve| curve.to_possible_value());
        Origin::new("ingest")
            .path(&self.set)
            .option("step", self.step)
            .option("curve", curve.map(|curve| curve.get_name().to_owned()))
            .option("preset", self.preset.map(Preset::name))
            .option("shape", self.shape.clone())
            .paths("mapping", &self.mapping)
            .option(PART, self.part)
    }
}
