//! `pushlab demo`: the whole story on recordings that hide an effect.

mod story;

use std::path::PathBuf;
use std::time::{SystemTime, UNIX_EPOCH};

use anyhow::Result;
use clap::value_parser;
use output::OutputError;
use plant::Profile;

use self::story::Story;
use crate::tool::command_line::seed_parser;
use crate::tool::commands::generate::rig_parser;
use crate::tool::destination::{Inputs, folder};
use crate::tool::file_ending;
use crate::tool::terminal::Terminal;

/// Hide an effect in simulated recordings, find it, add it, and watch the error fall
///
/// Runs the commands that one would type, and prints each before its answer. What is hidden is drawn
/// at random, also from effects that no catalogue has, and told at the end alone. Everything stays in
/// a folder, with a report to look at.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// Folder for all that is made; it may not have files in it
    #[arg(short, long, value_name = "DIR", default_value = "pushlab-demo",
          value_parser = file_ending::folder)]
    output: PathBuf,
    /// Seed of everything random; drawn from the clock without it, and told
    #[arg(long, value_name = "SEED", value_parser = seed_parser())]
    seed: Option<u64>,
    /// Hide this effect, as `pushlab generate` takes it
    #[arg(long, value_name = "EFFECT", default_value = "surprise")]
    hidden: String,
    /// Number of pushes
    #[arg(short = 'n', long, value_name = "N", default_value_t = 120,
          value_parser = value_parser!(u32).range(20..=10_000))]
    pushes: u32,
    /// What kind of rig it is, as `pushlab generate` takes it
    #[arg(long, value_name = "RIG", default_value = Profile::DEFAULT, value_parser = rig_parser())]
    rig: String,
}

const EXAMPLES: &str = "\
Examples:
  pushlab demo
  pushlab demo --seed 12 -o again
  pushlab demo --rig quiet --hidden table-tilt -o tilted";

pub(crate) fn run(args: &Args, terminal: &Terminal) -> Result<()> {
    folder(&args.output, &Inputs::default())?.fill(|_| Ok::<_, OutputError>(()))?;
    let story = Story {
        folder: &args.output,
        seed: args.seed.unwrap_or_else(seed_of_the_clock),
        hidden: &args.hidden,
        n_pushes: args.pushes,
        rig: &args.rig,
        terminal,
    };
    story.tell()
}

/// Another one every time.
fn seed_of_the_clock() -> u64 {
    let now = SystemTime::now().duration_since(UNIX_EPOCH);
    now.map_or(1, |since| since.subsec_micros().into())
}
