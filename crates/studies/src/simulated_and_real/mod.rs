//! `cargo xtask simulated-and-real`: the simulated table of steps beside a measured one.

mod cells;
mod described;
mod figure;
mod page;
mod words;

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

use crate::figures::inputs::Inputs;
use crate::figures::models::steps::Steps;
use crate::figures::{named, rigs, thesis_design};
use described::Described;
use validation::workspace_root;

/// Name of the page and of its picture.
const NAME: &str = "simulated-and-real";

/// Put the simulated table of the thesis' design beside a measured one, in docs/.
#[derive(clap::Args)]
pub struct Args {
    /// Table of measured steps (a file, or its folder, as `mit-push-table`); without it the
    /// simulated numbers are printed alone, and nothing is written
    #[arg(long, value_name = "PATH")]
    data: Option<PathBuf>,
    /// How rough the simulated rig is
    #[arg(long, value_name = "NAME", default_value = "quiet", value_parser = rigs())]
    rig: String,
    /// Folder for the page and its picture
    #[arg(short, long, value_name = "DIR", default_value = "docs", alias = "out")]
    output: PathBuf,
}

/// Describes both tables and writes the page, or prints what is simulated.
///
/// # Errors
/// Data that cannot be read; a model that cannot be learned; a file that cannot be written.
pub fn run(args: &Args) -> Result<()> {
    let sets = thesis_design(named(&args.rig)?)?;
    let slowest = sets.into_iter().next().context("a design has a slowest speed")?;
    let simulated = Steps::of(&Inputs::open(&slowest, false)?)?;
    let described = Described::of("simulated", &simulated)?;
    let Some(path) = &args.data else {
        print!("{}", page::table(&[described]));
        return Ok(());
    };
    let inputs = Inputs::open(path, false)?;
    let measured = Steps::of(&inputs)?;
    let out = workspace_root().join(&args.output);
    let both = [Described::of("measured", &measured)?, described];
    let picture = figure::draw([&measured.steps, &simulated.steps], &both).svg()?;
    write(&out.join(NAME).with_extension("svg"), &picture)?;
    let cells = cells::common([&measured.steps, &simulated.steps]);
    let paired = cells::paired(&measured.steps, &simulated.steps);
    let text = page::page(inputs.name(), &both, &cells, &paired);
    write(&out.join(NAME).with_extension("md"), &text)
}

fn write(path: &Path, text: &str) -> Result<()> {
    output::write(path, text)?;
    println!("written: {}", path.display());
    Ok(())
}
