//! `pushlab models show`: what a model file says.

use std::path::PathBuf;

use anyhow::Result;
use models::ModelFile;

use super::parameters::Parameters;
use crate::file_ending;
use crate::origin::{Input, Origin, readable};
use crate::terminal::Terminal;

/// Show what a model file says: kind, parameters, their errors and sources
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// Model file
    #[arg(default_value = "model.toml", value_parser = file_ending::model)]
    model: PathBuf,
}

const EXAMPLES: &str = "\
Examples:
  pushlab models show model.toml
  pushlab models show model.toml --json";

pub(crate) fn run(args: &Args, terminal: &Terminal) -> Result<()> {
    readable(&args.model)?;
    let file = ModelFile::read(&args.model)?;
    let mut origin = Origin::new("models show").path(&args.model);
    origin.inputs.push(Input::file(&args.model)?);
    let parameters = Parameters::of(&file);
    terminal.finish(&origin, &parameters, &parameters)
}
