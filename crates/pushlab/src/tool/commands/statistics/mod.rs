//! `pushlab statistics`: what a part of a set says of a model, as sums that `merge` puts together.

mod round;

use std::fmt;
use std::path::PathBuf;

use anyhow::{Result, bail};
use dataset::Part;
use diagnosis::{ErrorGrid, ErrorSums, FitPlace, FitSettings, Observations, Predictions};
use models::{Description, ModelFile};
use serde::Serialize;

pub(super) use self::round::{OfPart, Round, Statistics};
use super::compare::floor_about;
use crate::tool::command_line::effect_parser;
use crate::tool::destination::Force;
use crate::tool::document::document;
use crate::tool::file_ending;
use crate::tool::origin::{Input, Origin, readable};
use crate::tool::step_source::{Reading, StepSource};
use crate::tool::terminal::{TITLE, Terminal};
use crate::tool::wrong_usage::WrongUsage;

/// Sum up what a part of a set says of a model, for sets too large for one machine
///
/// Begin without --round, on a sample: it tells the noise, the cells of maps and, with --free, where a fit
/// starts. Then sum each part up with that as the --round. `pushlab merge` puts the parts together: errors, coverage and maps
/// of the whole set, and a fit's next step, from which the parts are summed up again until it has converged.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    #[command(flatten)]
    source: StepSource,
    /// Model file, to begin with
    #[arg(long, value_name = "FILE", default_value = "model.toml", conflicts_with = "round",
          value_parser = file_ending::model)]
    model: PathBuf,
    /// What to fit, as `fit` has it; without it errors alone are summed up
    #[arg(long, value_name = "IDS", value_delimiter = ',', conflicts_with = "round",
          value_parser = effect_parser(), hide_possible_values = true)]
    free: Vec<String>,
    /// What all parts share: what this wrote of a sample, or `merge` of the round before
    #[arg(long, value_name = "FILE", value_parser = file_ending::json)]
    round: Option<PathBuf>,
    /// Read one of so many parts of the recordings; of a table, say which part it is
    #[arg(long, value_name = "I/N")]
    part: Option<Part>,
    /// Where to write the statistics (.json; `-` is standard output)
    #[arg(short, long, value_name = "FILE",
          value_parser = file_ending::or_standard(file_ending::json))]
    output: PathBuf,
    #[command(flatten)]
    force: Force,
}

const EXAMPLES: &str = "\
Examples:
  pushlab statistics pushes --free pusher-friction --part 1/8 -o round-0.json    # the first part is the sample
  pushlab statistics pushes --round round-0.json --part 3/8 -o part-3.json        # on one of eight machines
  pushlab merge part-?.json -o round-1.json
  pushlab statistics pushes --round round-1.json --part 3/8 -o part-3.json --force
then, when it has converged:
  pushlab merge part-?.json --fitted fitted.toml";

/// What a sample says.
#[derive(Serialize)]
struct Begun {
    round: Round,
    #[serde(skip)]
    n: [usize; 2],
}

pub(crate) fn run(args: &Args, terminal: &Terminal) -> Result<()> {
    let terminal = &terminal.beside([args.output.as_path()])?;
    let known = args.round.as_ref().map(|path| Round::read(path)).transpose()?;
    let model = &known.as_ref().map_or(&args.model, |round| &round.model.path).clone();
    let inputs = args.source.inputs().with([model]).with(&args.round);
    let output = args.force.file(&args.output, &inputs)?;
    let mut origin = args.origin();
    origin.inputs.push(Input::file(args.round.as_ref().unwrap_or(model))?);
    readable(model)?;
    let document = match (known, args.part) {
        (Some(_), None) => {
            bail!(WrongUsage("sums are of a part: give --part, 1/1 for the whole set"))
        }
        (Some(round), Some(part)) => {
            let model = round.model()?;
            let steps = args.source.read_part(Reading::Look, args.part, terminal)?;
            origin.inputs.extend(steps.inputs);
            let of_part = of_part(&steps.observations, (part, round), &model)?;
            let text =
                format!("{TITLE}part {part}{TITLE:#}: {} steps", steps.observations.n_steps());
            let document = document(&origin, &terminal.warnings(), &of_part)?;
            terminal.finish(&origin, &of_part, text)?;
            document
        }
        (None, _) => {
            let file = ModelFile::read(model)?;
            let steps = args.source.read_part(Reading::Steady, args.part, terminal)?;
            steps.rig.warn_of_other(model, &file, terminal);
            origin.inputs.extend(steps.inputs);
            let begun = args.begin((&steps.rig.name, &steps.observations), &file)?;
            let document = document(&origin, &terminal.warnings(), &begun)?;
            terminal.finish(&origin, &begun, &begun)?;
            document
        }
    };
    Ok(output.write(document)?)
}

impl Args {
    /// What a sample tells all parts.
    fn begin(&self, (set, sample): (&str, &Observations), file: &ModelFile) -> Result<Begun> {
        let (model, free) = (&file.description, self.free.iter().map(String::as_str));
        let free: Vec<&str> = free.collect();
        let fit = match free[..] {
            [] => None,
            _ => Some(FitPlace::of_sample(sample, model, &free, &FitSettings::default())?),
        };
        let here = at(fit.as_ref(), sample, model)?;
        let predictions = Predictions::of(&here, &[], sample)?;
        let grid = ErrorGrid::of(sample, &predictions, &floor_about(&here, sample, sample)?);
        let round = Round { set: set.to_owned(), model: Input::file(&self.model)?, grid, fit };
        Ok(Begun { round, n: [sample.pushes().len(), sample.n_steps()] })
    }

    fn origin(&self) -> Origin {
        let begins = self.round.is_none();
        Origin::new("statistics")
            .path(&self.source.set)
            .paths("model", begins.then_some(&self.model))
            .option("free", (!self.free.is_empty()).then(|| self.free.join(",")))
            .words(self.source.words())
            .paths("round", &self.round)
            .option("part", self.part)
    }
}

/// The sums of a part.
fn of_part(part: &Observations, (of, round): (Part, Round), file: &ModelFile) -> Result<OfPart> {
    let model = &file.description;
    let here = at(round.fit.as_ref(), part, model)?;
    let predictions = Predictions::of(&here, &[], part)?;
    let errors = ErrorSums::of(part, &predictions, &round.grid)?;
    let equations = round.fit.as_ref();
    let equations =
        equations.map(|place| place.equations(part, model, &FitSettings::default())).transpose()?;
    Ok(OfPart { part: of, round, statistics: Statistics { errors, equations } })
}

/// The model where a fit of it stands.
fn at(fit: Option<&FitPlace>, steps: &Observations, model: &Description) -> Result<Description> {
    Ok(match fit {
        Some(place) => place.description(steps, model, &FitSettings::default())?,
        None => model.clone(),
    })
}

impl fmt::Display for Begun {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [pushes, steps] = self.n;
        let what = if self.round.fit.is_some() {
            "noise, cells of maps and start of a fit"
        } else {
            "cells of maps"
        };
        writeln!(f, "{TITLE}{what}{TITLE:#} from {steps} steps of {pushes} pushes")
    }
}
