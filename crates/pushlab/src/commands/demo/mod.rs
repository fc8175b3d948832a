//! `pushlab demo`: the whole story on recordings that hide an effect.

mod story;

use std::path::PathBuf;
use std::time::{SystemTime, UNIX_EPOCH};

use anyhow::Result;
use clap::value_parser;
use output::OutputError;

use self::story::Story;
use crate::destination::{Inputs, folder};
use crate::terminal::Terminal;

/// Hide an effect in simulated recordings, find it, add it, and watch the error fall
///
/// Runs the commands that one would type, and prints each before its answer. What is hidden is drawn
/// at random, also from effects that no catalogue has, and told at the end alone. Everything stays in
/// a folder, with a report to look at.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// Folder for all that is made; it may not have files in it
    #[arg(default_value = "pushlab-demo")]
    folder: PathBuf,
    /// Seed of everything random; else drawn from the clock, and told
    #[arg(long, value_name = "SEED", value_parser = value_parser!(u32))]
    seed: Option<u32>,
    /// Hide this effect, as `pushlab generate` takes it
    #[arg(long, value_name = "EFFECT", default_value = "surprise")]
    hidden: String,
    /// Number of pushes
    #[arg(long, value_name = "N", default_value_t = 80,
          value_parser = value_parser!(u32).range(20..=10_000))]
    pushes: u32,
}

const EXAMPLES: &str = "\
Examples:
  pushlab demo
  pushlab demo again --seed 12
  pushlab demo tilted --hidden table-tilt --pushes 200";

pub(crate) fn run(args: &Args, terminal: &Terminal) -> Result<()> {
    folder(&args.folder, &Inputs::default())?.fill(|_| Ok::<_, OutputError>(()))?;
    let story = Story {
        folder: &args.folder,
        seed: args.seed.unwrap_or_else(seed_of_the_clock),
        hidden: &args.hidden,
        n_pushes: args.pushes,
        terminal,
    };
    story.tell()
}

/// Another one every time.
fn seed_of_the_clock() -> u32 {
    let now = SystemTime::now().duration_since(UNIX_EPOCH);
    now.map_or(1, |since| since.subsec_micros())
}
