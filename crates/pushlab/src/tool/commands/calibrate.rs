//! `pushlab calibrate`: how sure a model may be of whole pushes, measured on recordings and kept in its file.

use std::fmt;
use std::path::PathBuf;

use anyhow::Result;
use models::{Calibration, ModelFile, Setup};
use serde::Serialize;

use crate::tool::destination::Force;
use crate::tool::file_ending;
use crate::tool::origin::{Input, Origin, readable};
use crate::tool::step_size::StepSize;
use crate::tool::step_source::StepSource;
use crate::tool::terminal::{TITLE, Terminal};
use crate::tool::whole_pushes::{Told, WholePushes, calibration};

/// Measure how sure a model may be of whole pushes, and keep it in the model's file
///
/// `simulate` then takes it from there where no other pushes are at hand: along a path, or of pushes of which
/// the ends alone are known. Of physics all pushes of the set tell, of a model that learnt those that it has not
/// seen. `fit`, `add --fit` and `train` measure it themselves; a model that `add` made from a diagnosis, or by
/// hand, has none yet.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    #[command(flatten)]
    source: StepSource,
    /// Model file
    #[arg(long, value_name = "FILE", default_value = "model.toml",
          value_parser = file_ending::model)]
    model: PathBuf,
    /// Length of a step of recordings: a time or a way, as of `simulate`; else 200ms
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true)]
    step: Option<StepSize>,
    /// Where to write the model with it; of a learnt one the weights are written beside it
    #[arg(short, long, value_name = "FILE",
          value_parser = file_ending::or_standard(file_ending::model))]
    output: PathBuf,
    #[command(flatten)]
    force: Force,
}

const EXAMPLES: &str = "\
Examples:
  pushlab calibrate pushes --model better.toml -o calibrated.toml
then:
  pushlab simulate arc.toml --manifest pushes/dataset.toml --model calibrated.toml -o out";

/// What was measured, and where it stands.
#[derive(Serialize)]
struct Calibrated {
    /// The model file.
    model: PathBuf,
    set: PathBuf,
    #[serde(flatten)]
    calibration: Calibration,
}

pub(crate) fn run(args: &Args, terminal: &Terminal) -> Result<()> {
    let terminal = &terminal.beside([args.output.as_path()])?;
    let mut origin = args.origin();
    readable(&args.model)?;
    let inputs = args.source.inputs().with([&args.model]);
    let destination = args.force.file(&args.output, &inputs)?;
    origin.inputs.push(Input::file(&args.model)?);
    let file = ModelFile::read(&args.model)?;
    let pushes = WholePushes::of_steps(&args.source, args.step, &file, &mut origin, terminal)?;
    pushes.rig.warn_of_other(&args.model, &file, terminal);
    let setup = Setup { support: pushes.rig.support, own: Vec::new() };
    let others = pushes.others(&[], &file);
    let calibration = calibration(&file.description, &setup, &others, terminal)?;
    ModelFile { calibration: Some(calibration.clone()), ..file }.write_to(destination)?;
    let (model, set) = (args.output.clone(), args.source.set.clone());
    let result = Calibrated { model, set, calibration };
    terminal.finish(&origin, &result, &result)
}

impl fmt::Display for Calibrated {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{TITLE}wrote {}{TITLE:#}", self.model.display())?;
        writeln!(f, "  {}", Told(&self.calibration))
    }
}

impl Args {
    fn origin(&self) -> Origin {
        Origin::new("calibrate")
            .path(&self.source.set)
            .paths("model", [&self.model])
            .option("step", self.step)
            .words(self.source.words())
    }
}
