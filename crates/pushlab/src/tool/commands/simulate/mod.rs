//! `pushlab simulate`: pushes rolled out by a model, with their uncertainty.

mod figure;
mod method;
mod motion_log;
mod path_file;
mod place;
mod poses;
mod result;
mod rolled;
mod tasks;

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use models::{
    Calibration, ContactGap, ModelFile, PushModel, RecordedPush, RollOutSettings, Setup,
    StepCorrelation, StepErrors,
};
use output::PartFolder;

use self::method::{Method, tabulated};
use self::place::Place;
use self::result::{How, Simulated, Sureness};
use self::rolled::{Rolled, Task};
use self::tasks::Source;
use crate::tool::command_line::seed_parser;
use crate::tool::destination::folder;
use crate::tool::document::document;
use crate::tool::file_ending;
use crate::tool::known::Known;
use crate::tool::origin::{Input, Origin, readable};
use crate::tool::step_size::StepSize;
use crate::tool::step_source::StepSource;
use crate::tool::terminal::Terminal;
use crate::tool::whole_pushes::calibration;

/// Roll pushes out by a model: where the object goes, and how sure that is
///
/// Particles go along the pusher's path, each with a contact of its own at every step, and draw their
/// motion from the model. Pushes are those of a recording set, which are compared with what was
/// measured, or one along a path from a file. With --matched a Gaussian goes along the path instead.
/// Of pushes of which the ends alone are known, the end is what is compared.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
#[command(mut_arg("manifest", |manifest| manifest.help(MANIFEST)))]
pub(crate) struct Args {
    /// Recording set (a folder with dataset.toml, or a file of poses before and after pushes with
    /// --preset), a step table (.csv, .parquet), or a path of the pusher (.csv, .toml)
    source: PathBuf,
    #[command(flatten)]
    known: Known,
    /// Model file
    #[arg(long, value_name = "FILE", default_value = "model.toml",
          value_parser = file_ending::model)]
    model: PathBuf,
    /// Folder for tables, figures and logs; it may not have files in it
    #[arg(short, long, value_name = "DIR", value_parser = file_ending::folder)]
    output: PathBuf,
    /// Number of particles
    #[arg(long, value_name = "N", default_value_t = 10_000,
          value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    particles: u32,
    /// Read a learnt model from tables, for many particles; their errors are told
    #[arg(long)]
    fast: bool,
    /// Do without particles: a mean and a covariance are carried along the path
    #[arg(long, value_name = "METHOD", conflicts_with_all = ["particles", "fast"])]
    matched: Option<Method>,
    /// Recorded pushes, as recording#number, with commas between; else an even choice of --pushes
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    push: Vec<String>,
    /// How many of the recorded pushes, of those that the model has not seen where it tells
    #[arg(short = 'n', long, value_name = "N", default_value_t = 8, conflicts_with = "push",
          value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pushes: u32,
    /// Recording set whose pushes tell how sure the model may be of whole pushes; else those of SOURCE
    /// that are not rolled out, or else what the model file keeps of `fit`, `train` or `calibrate`; `none` takes
    /// the model as it is
    #[arg(long, value_name = "SET|none")]
    correlation: Option<PathBuf>,
    /// Longest step of a path, or of a push of which the ends are known: a way (4mm) or a time (200ms);
    /// of other recordings as of `compare`; else as long as the model's
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true)]
    step: Option<StepSize>,
    /// Of a path: where the object is at the start, in mm and degrees; else as the path's file says,
    /// or 0,0,0
    #[arg(long, value_name = "X,Y,ANGLE", allow_hyphen_values = true)]
    object: Option<Place>,
    /// Seed of everything random
    #[arg(long, value_name = "SEED", default_value_t = 7, value_parser = seed_parser())]
    seed: u64,
}

const MANIFEST: &str = "Manifest with object, pusher and table, of a path or of a step table; of a table else \
                        dataset.toml beside it";

const EXAMPLES: &str = "\
Examples:
  pushlab simulate pushes --model gp.toml -o out
  pushlab simulate pushes --model gp.toml --push push-007#0 -o out
  pushlab simulate pushes --model gp.toml --fast --particles 1000000 -o out
  pushlab simulate pushes --model gp.toml --matched exact -o out
  pushlab simulate steps.csv --manifest pushes/dataset.toml --model gp.toml -o out
  pushlab simulate plywood.csv --preset mit-endpoints --shape hex --model mit.toml -o out
  pushlab simulate arc.toml --manifest pushes/dataset.toml --model gp.toml --correlation pushes -o out
A path file: kind = \"spline\", speed_mm_s = 20, points_mm = [[-60, 0], [-20, 10], [40, 0]]";

pub(crate) fn run(args: &Args, terminal: &Terminal) -> Result<()> {
    let source = StepSource::of(&args.source, args.known.clone());
    let mut inputs = source.inputs().with([&args.model]);
    if let Some(set) = args.measured_on() {
        inputs = inputs.with_set(set, None);
    }
    let destination = folder(&args.output, &inputs)?;
    let mut origin = args.origin();
    readable(&args.model)?;
    readable(&args.source)?;
    origin.inputs.push(Input::file(&args.model)?);
    let file = ModelFile::read(&args.model)?;
    let source = Source::read(args, &file, &mut origin, terminal)?;
    let setup = Setup { support: source.support, own: Vec::new() };
    let found = how_sure(args, (source.others.as_deref(), &setup), &file, terminal)?;
    let description = match &found {
        Some(found) => file.description.with(found)?,
        None => file.description.clone(),
    };
    let model = description.build_in(setup.support, &setup.own)?;
    let settings =
        args.settings(&source, found.as_ref().and_then(|found| found.correlation.as_ref()));
    let (table, tables) = args.fast.then(|| tabulated(model.as_ref())).transpose()?.unzip();
    let model = table.as_ref().map_or(model.as_ref(), |table| table as &dyn PushModel);
    let rolled = all_rolled(args, source.tasks, (model, &settings), terminal)?;
    let sureness = Sureness::of(&description.base, model);
    let matched = args.matched;
    let how = How { settings: &settings, tables, matched, calibration: found, sureness };
    let result = Simulated::new(&args.output, &file.name, how, &rolled);
    let json = document(&origin, &terminal.warnings(), &result)?;
    destination.fill(|part| write(part, &rolled, json, &origin))?;
    terminal.finish(&origin, &result, &result)
}

/// How sure the model may be: as other pushes tell; where none are at hand, as its file does. Where nobody asked for it
/// and neither tells, that is said, and the model stays as it is.
fn how_sure(
    args: &Args,
    (others, setup): (Option<&[RecordedPush]>, &Setup),
    file: &ModelFile,
    terminal: &Terminal,
) -> Result<Option<Calibration>> {
    let kept = file.calibration.as_ref().filter(|_| args.correlation.is_none());
    let Some(others) = others else { return Ok(kept.cloned()) };
    match calibration(&file.description, setup, others, terminal) {
        Err(why) if args.measured_on().is_none() => {
            let instead = if kept.is_some() { "; the model file does" } else { "" };
            terminal.remark(format_args!(
                "the set's other pushes do not tell how sure the model may be: {why}{instead}"
            ));
            Ok(kept.cloned())
        }
        found => Ok(Some(found?)),
    }
}

/// The pushes as they go by a model. Of an even choice those that cannot be rolled out are named and left
/// out, as long as others can.
///
/// # Errors
/// What the model says of a push that was asked for, or of the first one where it says so of all.
fn all_rolled(
    args: &Args,
    tasks: Vec<Task>,
    (model, settings): (&dyn PushModel, &RollOutSettings),
    terminal: &Terminal,
) -> Result<Vec<Rolled>> {
    let n = tasks.len();
    let (mut rolled, mut left_out) = (Vec::new(), Vec::new());
    let mut progress = terminal.progress("pushes rolled out:", n);
    for task in tasks {
        let name = task.name.clone();
        match task.roll_out(model, settings, args.matched) {
            Ok(one) => rolled.push(one),
            Err(error) if args.push.is_empty() => left_out.push((name, error)),
            Err(error) => return Err(error).with_context(|| cannot(&name)),
        }
        progress.advance();
    }
    progress.finish();
    if rolled.is_empty() && !left_out.is_empty() {
        let (name, error) = left_out.swap_remove(0);
        return Err(error).with_context(|| cannot(&name));
    }
    if !left_out.is_empty() {
        let told = left_out.iter().map(|(name, error)| format!("{name} ({error:#})"));
        let (n_out, told) = (left_out.len(), told.collect::<Vec<_>>().join(", "));
        terminal.warn(format_args!("{n_out} of {n} pushes cannot be rolled out: {told}"));
    }
    Ok(rolled)
}

fn cannot(name: &str) -> String {
    format!("cannot roll out {name}")
}

/// Every file of the result.
fn write(part: &PartFolder, rolled: &[Rolled], json: String, origin: &Origin) -> Result<()> {
    part.write("poses.csv", [origin.comment().into_bytes(), poses::table(rolled)?].concat())?;
    part.write("simulation.json", json)?;
    for one in rolled {
        let name = one.file_name();
        part.write(&format!("{name}.mcap"), motion_log::motion_log(one, origin)?)?;
        let figure = figure::figure(one);
        part.write(&format!("{name}.svg"), figure.svg()?)?;
        part.write(&format!("{name}.png"), figure.png()?)?;
    }
    Ok(())
}

impl Args {
    fn settings(&self, source: &Source, correlation: Option<&StepCorrelation>) -> RollOutSettings {
        RollOutSettings {
            n_particles: self.particles as usize,
            seed: self.seed,
            step: source.longest,
            errors: correlation
                .map_or(StepErrors::Independent, |found| StepErrors::Held(found.clone())),
            gap: correlation.map_or_else(ContactGap::default, |found| found.gap),
            ..RollOutSettings::default()
        }
    }

    /// The set that was named to tell how sure the model may be.
    fn measured_on(&self) -> Option<&Path> {
        self.correlation.as_deref().filter(|set| set.as_os_str() != "none")
    }

    fn origin(&self) -> Origin {
        let has_particles = self.matched.is_none();
        Origin::new("simulate")
            .path(&self.source)
            .words(self.known.words())
            .paths("model", [&self.model])
            .option("matched", self.matched.map(Method::name))
            .option("particles", has_particles.then_some(self.particles))
            .option("push", (!self.push.is_empty()).then(|| self.push.join(",")))
            .option("pushes", self.push.is_empty().then_some(self.pushes))
            .paths("correlation", &self.correlation)
            .option("step", self.step)
            .option("object", self.object)
            .option("seed", [self.seed])
            .words(self.fast.then(|| "--fast".to_owned()))
    }
}
