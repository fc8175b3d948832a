//! `pushlab compare`: where a model fails on recordings, and how wrong it may be at best.

mod part;
mod residuals;
mod text;

use std::path::{Path, PathBuf};

use anyhow::Result;
use dataset::Suspicion;
use diagnosis::{
    ChannelChange, Comparison, MapSettings, Observations, Predictions, PushEnds, change, compare,
    push_ends, roll_out,
};
use models::{Base, Description, ModelFile, Unexplained};
use serde::Serialize;

pub(super) use self::part::{Part, floor_about};
pub(super) use self::text::{widened, write_calibration, write_error};
use crate::tool::destination::Force;
use crate::tool::document::document;
use crate::tool::file_ending;
use crate::tool::origin::{Input, Origin, readable};
use crate::tool::step_kind::StepKind;
use crate::tool::step_size::StepSize;
use crate::tool::step_source::{Reading, StepSource, Steps};
use crate::tool::terminal::Terminal;

/// Tell how wrong a model is on recordings, where, and how wrong it may be at best
///
/// Each step is predicted from its measured start along the pusher's measured way: the steps that
/// `diagnose` takes, where noise is known, or with --step all in contact. The floor is how far repeated
/// pushes differ from each other, and where few places are repeated what that tells of others; without
/// repeats it is estimated from neighbours. Where a model was fitted to a part of these recordings,
/// only the held-out pushes count.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    #[command(flatten)]
    source: StepSource,
    /// Model file
    #[arg(long, value_name = "FILE", default_value = "model.toml",
          value_parser = file_ending::model)]
    model: PathBuf,
    /// Another model, to tell how the error changes from it on the same steps
    #[arg(long, value_name = "FILE", value_parser = file_ending::model)]
    against: Option<PathBuf>,
    /// Length of a step, of all that is in contact: a time (200ms, 0.2s) or a way of the pusher (4mm, 0.4cm);
    /// else 5mm of smoothed motion, away from vertices
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true)]
    step: Option<StepSize>,
    /// Where to write the result as JSON (.json, docs/comparison.schema.json; `-` is standard output), or every
    /// step as a table (.csv, .parquet): what was done, measured, predicted and left, and in which part its push was
    #[arg(short, long, value_name = "FILE",
          value_parser = file_ending::or_standard(file_ending::json_or_table))]
    output: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
}

const EXAMPLES: &str = "\
Examples:
  pushlab compare pushes --model model.toml
  pushlab compare pushes --model better.toml --against model.toml
  pushlab compare pushes --step 4mm --json
  pushlab compare pushes -o comparison.json
  pushlab compare pushes --model better.toml -o residuals.parquet
  pushlab compare steps.csv --manifest pushes/dataset.toml
  pushlab compare table.csv --preset mit-table";

/// A model on a set, and how it does beside another one.
#[derive(Serialize)]
struct Compared {
    /// The model's name.
    model: String,
    /// Which pushes are compared.
    part: Part,
    /// What a step is.
    step: StepKind,
    /// Of a hybrid: shares of what was learnt in what it says of these steps.
    unexplained: Option<Unexplained>,
    #[serde(flatten)]
    comparison: Comparison,
    /// Whole pushes; none where every push is one step.
    roll_outs: Option<PushEnds>,
    against: Option<Against>,
    /// What of the recordings may be wrong; the errors hold only if none of it is.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    suspicions: Vec<Suspicion>,
}

/// How the error changes from another model.
#[derive(Serialize)]
struct Against {
    /// The other model's name.
    model: String,
    changes: Vec<ChannelChange>,
}

pub(crate) fn run(args: &Args, terminal: &Terminal) -> Result<()> {
    let terminal = &terminal.beside(args.output.as_deref())?;
    let inputs = args.source.inputs().with([&args.model]).with(&args.against);
    let output = args.output.as_deref();
    let output = output.map(|output| args.force.file(output, &inputs)).transpose()?;
    let mut origin = args.origin();
    let mut read = |path: &Path| -> Result<ModelFile> {
        readable(path)?;
        origin.inputs.push(Input::file(path)?);
        Ok(ModelFile::read(path)?)
    };
    let model = read(&args.model)?;
    let other = args.against.as_deref().map(&mut read).transpose()?;
    let Steps { rig, observations: all, kind: step, in_contact, inputs, suspicions, .. } =
        args.source.read(Reading::looked_at(args.step), terminal)?;
    origin.inputs.extend(inputs);
    rig.warn_of_other(&args.model, &model, terminal);
    if let (Some(path), Some(other)) = (&args.against, &other) {
        rig.warn_of_other(path, other, terminal);
    }
    let splits =
        [Some(&model), other.as_ref()].into_iter().flatten().filter_map(|f| f.split.as_ref());
    let part = Part::of(splits, &all);
    let is_table = |path: &PathBuf| path.extension().is_some_and(|ending| ending != "json");
    // Those that the model was fitted to as well.
    let steps = args.output.as_ref().filter(|path| is_table(path));
    let steps = steps.map(|_| residuals::of(&model.description, &all, &part)).transpose()?;
    let whole = in_contact.map(|whole| part.observations(whole)).transpose()?;
    let observations = part.observations(all.clone())?;
    let floor = floor_about(&model.description, &all, &observations)?;
    let predict = |file: &ModelFile| Predictions::of(&file.description, &[], &observations);
    let activity = terminal.activity();
    activity.tell("predicting every step");
    let predictions = predict(&model)?;
    let comparison = compare(&observations, &predictions, &floor, &MapSettings::default())?;
    activity.tell("rolling out whole pushes");
    let whole = whole.as_ref().unwrap_or(&observations);
    let rollouts = roll_out(&model.description, &[], whole)?;
    let roll_outs = push_ends(&rollouts);
    let against = match other {
        Some(other) => {
            let changes = change(&observations, &predict(&other)?, &predictions, &floor)?;
            Some(Against { model: other.name, changes })
        }
        None => None,
    };
    activity.finish();
    let unexplained = unexplained(&model.description, &observations)?;
    let model = model.name;
    let result =
        Compared { model, part, step, unexplained, comparison, roll_outs, against, suspicions };
    match (output, steps) {
        (Some(output), None) => output.write(document(&origin, &terminal.warnings(), &result)?)?,
        (Some(output), Some(steps)) => residuals::write(output, &steps, &origin)?,
        (None, _) => {}
    }
    terminal.finish(&origin, &result, &result)
}

/// How much of what a hybrid says no physics explains.
fn unexplained(model: &Description, observations: &Observations) -> Result<Option<Unexplained>> {
    let Base::Hybrid(_) = model.base else { return Ok(None) };
    let built = model.build_in(observations.support(), &[])?;
    Ok(Some(built.unexplained(&observations.motion_inputs()?)?))
}

impl Args {
    fn origin(&self) -> Origin {
        Origin::new("compare")
            .path(&self.source.set)
            .paths("model", [&self.model])
            .paths("against", &self.against)
            .words(self.source.words())
            .option("step", self.step)
    }
}
