//! `pushlab run`: all the way from recordings to a better model, and a report of it.

mod asked;
mod chain;
mod ledger;
mod manifest;
mod stated;
mod summary;

use std::path::PathBuf;

use anyhow::{Result, ensure};
use diagnosis::Diagnosis;
use output::OutputError;

use self::chain::{
    BETTER, CALIBRATED, CHANGE, COMPARISON, Chain, DIAGNOSIS, MODEL, PAGE, Phase, STEPS,
};
use self::manifest::Draft;
use self::stated::Stated;
use self::summary::Ran;
use crate::tool::command_line::seed_parser;
use crate::tool::destination::{Inputs, folder};
use crate::tool::diagnosis_file::lowers_the_error;
use crate::tool::file_ending;
use crate::tool::origin::{Origin, readable};
use crate::tool::terminal::Terminal;

/// Go all the way from recordings to a better model, and a report of it
///
/// Runs the commands that one would type, one after the other: init, ingest, models init, compare,
/// diagnose, add --all, compare --against, report, calibrate. FOLDER has recordings, with or without dataset.toml;
/// without it one is written there. What no recording tells (outline, mass, radius of the tip, friction)
/// is asked for on a terminal, and else stated with --set.
///
/// All that is made lies in DIR: steps.csv, the step table; model.toml, the nominal model; comparison.json, its
/// errors; diagnosis.json, what it lacks; better.toml, the model with that; comparison-better.json, its
/// errors beside those of model.toml; report.html, the page with all of it; calibrated.toml, the better model with
/// how sure it may be of whole pushes, for `simulate`. phases.json says what each was
/// made from: the next run does again only what is not there, or what was made from something else.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// Folder of recordings, or of a recording set
    folder: PathBuf,
    /// Folder for all that is made, new or from an earlier run
    #[arg(short, long, value_name = "DIR", value_parser = file_ending::folder)]
    output: PathBuf,
    /// What dataset.toml leaves open, in SI units; once for each number
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<Stated>,
    /// Seed of the choice of held-out pushes
    #[arg(long, value_name = "SEED", default_value_t = 7, value_parser = seed_parser())]
    seed: u64,
    /// Do everything anew, and replace what is in DIR; inputs are never replaced
    #[arg(long)]
    force: bool,
}

const EXAMPLES: &str = "\
Examples:
  pushlab run my-pushes -o result
  pushlab run my-pushes -o result --set object.shape=square --set object.side_m=0.09 \\
    --set object.mass_kg=0.8 --set pusher.radius_m=0.005 --set pusher.friction=0.25 \\
    --set support.friction=0.25
  pushlab run my-pushes -o result --force";

pub(crate) fn run(args: &Args, terminal: &Terminal) -> Result<()> {
    let set = args.folder.display();
    ensure!(
        readable(&args.folder)?.is_dir(),
        "{set} is a file: `run` takes a folder of recordings; a step table is what `pushlab compare` and \
         `pushlab diagnose` take"
    );
    let draft = Draft::of(&args.folder)?;
    let recordings = draft.recordings(&args.folder)?;
    let inputs = || Inputs::default().with_set(&args.folder, None).with(&recordings);
    let mut chain = Chain::new(args, terminal);
    let new_folder = match args.output.is_dir() {
        true => {
            chain.check_outputs(&inputs())?;
            None
        }
        false => Some(folder(&args.output, &inputs())?),
    };
    let manifest = draft.filled_in(args, terminal)?;
    if let Some(new_folder) = new_folder {
        new_folder.fill(|_| Ok::<_, OutputError>(()))?;
    }
    // With dataset.toml it is known where the recordings are, among which nothing may be written.
    chain.check_outputs(&inputs())?;
    chain.begin(manifest)?;
    let (found, model) = go(&mut chain).inspect_err(|_| {
        terminal.note("stopped: what is done stays, and the same command goes on from here");
    })?;
    let mut origin = args.origin();
    origin.inputs.clone_from(&chain.set);
    let ran = Ran::of(args, chain, found, model);
    terminal.finish(&origin, &ran, &ran)
}

/// Every phase after the manifest; what was found, and the model to go on with.
fn go(chain: &mut Chain) -> Result<(Diagnosis, &'static str)> {
    let (model, better, diagnosis) = (chain.path(MODEL), chain.path(BETTER), chain.path(DIAGNOSIS));
    let seed = chain.seed().to_string();
    let diagnose = Phase::of_set("diagnose", DIAGNOSIS).with(["--seed", &seed]);
    chain.go(&Phase::of_set("ingest", STEPS))?;
    chain.go(&Phase::of_set("models init", MODEL))?;
    chain.go(&Phase::of_set("compare", COMPARISON).reading("model", &model))?;
    chain.go(&diagnose.reading("model", &model))?;
    let found = Diagnosis::read(&diagnosis)?;
    let model_name = if lowers_the_error(&found) { BETTER } else { MODEL };
    if model_name == BETTER {
        let add = Phase::of_files("add", BETTER).with(["--all"]);
        chain.go(&add.reading("from", &diagnosis).reading("model", &model))?;
        let compare = Phase::of_set("compare", CHANGE).reading("model", &better);
        chain.go(&compare.reading("against", &model))?;
    } else {
        chain.pass_over("add", BETTER);
        chain.pass_over("compare", CHANGE);
    }
    let model = chain.path(model_name);
    let report = Phase::of_set("report", PAGE).reading("model", &model);
    chain.go(&report.reading("from", &diagnosis))?;
    let calibrate = Phase::of_set("calibrate", CALIBRATED).reading("model", &model);
    let is_calibrated = chain.go_if_told(&calibrate)?;
    Ok((found, if is_calibrated { CALIBRATED } else { model_name }))
}

impl Args {
    fn origin(&self) -> Origin {
        Origin::new("run").path(&self.folder).option("set", &self.set).option("seed", [self.seed])
    }
}
