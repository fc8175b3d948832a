//! `pushlab fit`: nominal parameters and effects of a model, fitted to recordings.

use std::path::PathBuf;

use anyhow::Result;

use crate::tool::command_line::{effect_parser, seed_parser};
use crate::tool::destination::Force;
use crate::tool::file_ending;
use crate::tool::fitting::{FitOptions, Fitting, model_for};
use crate::tool::origin::Origin;
use crate::tool::step_source::StepSource;
use crate::tool::terminal::Terminal;

/// Fit nominal parameters, or effects that a model carries, to recordings
///
/// A quarter of the pushes is held out first, for `compare`. Parameters that the pushes do
/// not determine are refused, with what would determine them.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    #[command(flatten)]
    source: StepSource,
    /// What to fit: pusher-friction, pressure-radius, support-friction, or ids of effects
    #[arg(long, value_name = "IDS", required = true, value_delimiter = ',',
          value_parser = effect_parser(), hide_possible_values = true)]
    free: Vec<String>,
    #[command(flatten)]
    options: FitOptions,
    /// Model file to start from
    #[arg(long, value_name = "FILE", default_value = "model.toml",
          value_parser = file_ending::model)]
    model: PathBuf,
    /// Where to write the fitted model; `-` is standard output
    #[arg(short, long, value_name = "FILE",
          value_parser = file_ending::or_standard(file_ending::model))]
    output: PathBuf,
    /// Seed of the choice of held-out pushes
    #[arg(long, value_name = "SEED", default_value_t = 7, value_parser = seed_parser())]
    seed: u64,
    #[command(flatten)]
    force: Force,
}

const EXAMPLES: &str = "\
Examples:
  pushlab fit pushes --free pusher-friction -o fitted.toml
  pushlab fit pushes --free pusher-friction,pressure-radius --model nominal.toml -o fitted.toml
  pushlab fit table.csv --preset mit-table --free pusher-friction -o fitted.toml
  pushlab fit pushes --free pusher-friction,support-points --points 3 --by-statics -o feet.toml
then:
  pushlab compare pushes --model fitted.toml --against model.toml";

pub(crate) fn run(args: &Args, terminal: &Terminal) -> Result<()> {
    let terminal = &terminal.beside([args.output.as_path()])?;
    let mut origin = args.origin();
    let inputs = args.source.inputs();
    let output = (args.output.as_path(), &args.force);
    let (model, destination) = model_for(&args.model, output, inputs, &mut origin)?;
    let free: Vec<&str> = args.free.iter().map(String::as_str).collect();
    args.options.check(&free, &model)?;
    let source = (&args.source, &args.options);
    let fitting = Fitting::read(source, &model, args.seed, &mut origin, terminal)?;
    let fit = fitting.fit(&model, &free)?.determined()?;
    let fitted = fitting.write(
        fit,
        format!("{}, fitted", model.name),
        (&args.source, destination),
        terminal,
    )?;
    terminal.finish(&origin, &fitted, &fitted)
}

impl Args {
    fn origin(&self) -> Origin {
        Origin::new("fit")
            .path(&self.source.set)
            .option("free", [self.free.join(",")])
            .words(self.options.words())
            .paths("model", [&self.model])
            .words(self.source.words())
            .option("seed", [self.seed])
    }
}
