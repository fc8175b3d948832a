//! `pushlab diagnose`: which physical effect a model lacks.

mod text;

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use diagnosis::{DiagnoseSettings, Diagnosis, MadeBy, MadeFrom, diagnose};
use models::ModelFile;

use crate::destination::Destination;
use crate::file_ending;
use crate::origin::{Input, Origin, readable};
use crate::step_source::{Reading, StepSource, Steps};
use crate::suspected::warn_of_narrowness;
use crate::terminal::Terminal;

/// Name the physical effect that a model lacks, or say that these recordings cannot tell
///
/// A quarter of the pushes is set aside. On the others every effect of the catalogue is tested, the
/// likeliest are fitted together with the nominal numbers, and what is claimed has to predict the
/// pushes set aside better. The answer may be: these effects; one of these; none that is known;
/// none; or nothing that is sure.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    #[command(flatten)]
    source: StepSource,
    /// Model file
    #[arg(long, value_name = "FILE", default_value = "model.toml",
          value_parser = file_ending::model)]
    model: PathBuf,
    /// Where to write the answer as JSON (docs/diagnosis.schema.json)
    #[arg(short, long, value_name = "FILE", value_parser = file_ending::json)]
    output: Option<PathBuf>,
    /// The same as `--output`, as in `--json diagnosis.json`
    #[arg(value_name = "ANSWER", hide = true, value_parser = file_ending::json)]
    answer: Option<PathBuf>,
    /// Seed of the choice of pushes that are set aside
    #[arg(long, default_value_t = 7)]
    seed: u64,
}

const EXAMPLES: &str = "\
Examples:
  pushlab diagnose pushes --model model.toml
  pushlab diagnose pushes --model model.toml -o diagnosis.json
  pushlab diagnose mit-push-table/table.csv --preset mit-table --model mit.toml
  pushlab add --from diagnosis.json --model model.toml -o better.toml
  pushlab compare pushes --model better.toml --against model.toml";

pub(crate) fn run(args: &Args, terminal: &Terminal) -> Result<()> {
    let output = args.output.as_deref().or(args.answer.as_deref());
    let output = output.map(Destination::new).transpose()?;
    let mut origin = args.origin();
    readable(&args.model)?;
    origin.inputs.push(Input::file(&args.model)?);
    let model = ModelFile::read(&args.model)?;
    let Steps { observations, inputs, n_pushes } = args.source.read(Reading::Steady, terminal)?;
    origin.inputs.extend(inputs);
    warn_of_narrowness(&observations, terminal);
    let split = model.split.clone().filter(|split| observations.are_of(split));
    let n_used = observations.pushes().len();
    let n_pushes_set_aside = n_pushes.map_or(0, |n_pushes| n_pushes - n_used);
    let settings = DiagnoseSettings {
        split,
        seed: args.seed,
        n_pushes_set_aside,
        ..DiagnoseSettings::default()
    };
    let mut found = diagnose(&observations, &model.description, &settings)?.diagnosis;
    found.made_by = Some(made_by(&origin));
    if let Some(output) = output {
        output.write(to_json(&found)?.as_bytes())?;
    }
    terminal.finish_plain(&to_json(&found)?, text::Answer { found: &found, model: &model.name })
}

/// The answer alone: programs read its fields at the top.
fn to_json(found: &Diagnosis) -> Result<String> {
    Ok(serde_json::to_string_pretty(found).context("cannot write JSON")? + "\n")
}

fn made_by(origin: &Origin) -> MadeBy {
    let input = |input: &Input| MadeFrom {
        path: input.path.display().to_string(),
        sha256: input.sha256.clone(),
    };
    MadeBy {
        tool: origin.tool.to_owned(),
        arguments: origin.arguments.clone(),
        inputs: origin.inputs.iter().map(input).collect(),
    }
}

impl Args {
    fn origin(&self) -> Origin {
        let path = |path: &Path| path.display().to_string();
        let words = ["diagnose", &path(&self.source.set), "--model", &path(&self.model), "--seed"];
        let words = words.map(str::to_owned).into_iter().chain([self.seed.to_string()]);
        Origin::new(words.chain(self.source.words()))
    }
}
