//! `pushlab generate`: a recording set from the simulated rig, with a sealed truth.

mod design_name;
mod generated;
mod settings_file;
mod shape_name;

use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use anyhow::{Context, Result, bail};
use clap::builder::PossibleValuesParser;
use clap::value_parser;
use dataset::all_writers;
use plant::{GenerateSettings, Hidden, Layout, Profile, SetOutput, generate_each};

use self::design_name::DesignName;
use self::generated::Generated;
use self::settings_file::SettingsFile;
use self::shape_name::ShapeName;
use crate::tool::command_line::seed_parser;
use crate::tool::destination::Inputs;
use crate::tool::file_ending;
use crate::tool::origin::{Input, Origin, readable};
use crate::tool::progress::Progress;
use crate::tool::speed::Speed;
use crate::tool::terminal::Terminal;
use crate::tool::wrong_usage::WrongUsage;

/// Simulate pushes and write them as a recording set that can hide an effect
///
/// A rig with dynamics, made independently of the models: a measured-looking set for which the truth
/// is known. The truth goes to DIR.truth.toml beside the set, which no other command reads; a
/// surprise is told nowhere else. `pushlab effects list` names what can be hidden.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// Folder of the new set; it may not have files in it
    #[arg(short, long, value_name = "DIR", value_parser = file_ending::folder)]
    output: PathBuf,
    /// Hide this effect, 'ID' or 'ID: NAME=VALUE, …', or a `surprise`; may be given several times
    #[arg(long, value_name = "EFFECT")]
    hidden: Vec<String>,
    /// Number of pushes; else 200, or all of the thesis' design or of a file
    #[arg(short = 'n', long, value_name = "N",
          value_parser = value_parser!(u32).range(1..=1_000_000))]
    pushes: Option<u32>,
    /// Seed of everything random
    #[arg(long, value_name = "SEED", default_value_t = 7, value_parser = seed_parser())]
    seed: u64,
    /// Which pushes: random (the default), thesis, narrow, repeats, or a FILE.csv with one a line
    #[arg(long, value_name = "DESIGN")]
    design: Option<DesignName>,
    /// Measuring sessions that the pushes are spread over, each with friction of its own; else 1
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..=1_000_000))]
    sessions: Option<u32>,
    /// The pusher's speeds, such as 20mm/s or 20mm/s,100mm/s; else 20mm/s, or the thesis' five
    #[arg(long, value_name = "SPEED", value_delimiter = ',')]
    speed: Vec<Speed>,
    /// The object: one of the MIT push data set's, or a dataset.toml, whose rig is taken with it
    #[arg(long, value_name = "NAME|FILE", default_value = "rect1")]
    shape: ShapeName,
    /// What kind of rig it is: rough as real ones are, rough on a published surface, or quiet
    #[arg(long, value_name = "RIG", default_value = Profile::DEFAULT, value_parser = rig_parser())]
    rig: String,
    /// Sensors, scatter, the design's details and the truth from this file
    #[arg(long, value_name = "FILE")]
    settings: Option<PathBuf>,
    /// How recordings are written
    #[arg(long, value_name = "FORMAT", default_value = "mcap-ros2", value_parser = format_parser())]
    format: String,
}

const EXAMPLES: &str = "\
Examples:
  pushlab generate --hidden 'table-anisotropy: ratio=1.3, direction_deg=34' -o set
  pushlab generate --hidden surprise -n 400 --seed 12 -o set
  pushlab generate --design thesis --shape tri1 --format csv -o set
  pushlab generate --rig quiet --hidden cable -o set
  pushlab generate --design pushes.csv --hidden table-tilt --hidden pusher-radius -o set
  pushlab generate --shape my-pushes/dataset.toml --settings rig.toml --sessions 5 -o twin";

/// Names of the rigs, for a command line.
pub(super) fn rig_parser() -> PossibleValuesParser {
    PossibleValuesParser::new(Profile::all().iter().map(|profile| profile.name))
}

fn format_parser() -> PossibleValuesParser {
    PossibleValuesParser::new(all_writers().iter().map(|writer| writer.id()))
}

pub(crate) fn run(args: &Args, terminal: &Terminal) -> Result<()> {
    let out = SetOutput::apart_from(&Inputs::default().with(&args.files()).paths, &args.output)?;
    let settings = args.settings()?;
    let mut origin = args.origin();
    for path in args.files() {
        origin.inputs.push(Input::file(&path)?);
    }
    let progress: Mutex<Option<Progress>> = Mutex::new(None);
    // The set itself must not tell what it hides: what made it stands below its truth.
    let out = out.with_comment(format!("\n{}", origin.comment()));
    let report = generate_each(&settings, out, |n_pushes| {
        let mut progress = progress.lock().unwrap_or_else(PoisonError::into_inner);
        progress.get_or_insert_with(|| terminal.progress("pushes made:", n_pushes)).advance();
    });
    if let Some(progress) = progress.into_inner().unwrap_or_else(PoisonError::into_inner) {
        progress.finish();
    }
    let report = report?;
    let result = Generated::new(&report, args);
    terminal.finish(&origin, &result, &result)
}

impl Args {
    fn settings(&self) -> Result<GenerateSettings> {
        let hidden =
            self.hidden.iter().map(|text| Ok(text.parse()?)).collect::<Result<Vec<Hidden>>>()?;
        let profile = Profile::named(&self.rig).context("the parser knows the rigs")?;
        let (object, told) = self.shape.rig()?;
        let nominal = told.unwrap_or_else(|| profile.nominal());
        let usual = SettingsFile::usual(profile, &nominal);
        let file = match &self.settings {
            Some(path) => {
                readable(path)?;
                SettingsFile::read(path, &usual)?
            }
            None => usual,
        };
        let SettingsFile { mut design, sensors, scatter, numerics, truth } = file;
        if let Some(name) = &self.design {
            design.layout = name.layout()?;
            if matches!(design.layout, Layout::Thesis | Layout::List(_)) {
                design.n_pushes = 0;
            }
        }
        if matches!(design.layout, Layout::List(_)) {
            if !self.speed.is_empty() {
                bail!(WrongUsage("this design has its own speeds: leave out --speed"));
            }
            if self.sessions.is_some() {
                bail!(WrongUsage("this design has its own sessions: leave out --sessions"));
            }
        }
        if let Some(n_pushes) = self.pushes {
            design.n_pushes = n_pushes as usize;
        }
        if let Some(n_sessions) = self.sessions {
            design.n_sessions = n_sessions as usize;
        }
        if !self.speed.is_empty() {
            design.speeds = self.speed.iter().map(|Speed(speed)| *speed).collect();
        }
        Ok(GenerateSettings {
            name: format!("simulated pushes of {}", self.shape),
            object,
            nominal,
            truth: truth.unwrap_or_else(|| profile.truth(&nominal)),
            hidden,
            design,
            scatter,
            sensors,
            numerics,
            format: self.format.clone(),
            seed: self.seed,
        })
    }

    /// The files that are read.
    fn files(&self) -> Vec<PathBuf> {
        let list = match &self.design {
            Some(DesignName::File(path)) => Some(path.clone()),
            _ => None,
        };
        [list, self.shape.manifest(), self.settings.clone()].into_iter().flatten().collect()
    }

    /// What decides the result.
    fn origin(&self) -> Origin {
        Origin::new("generate")
            .option("hidden", &self.hidden)
            .option("pushes", self.pushes)
            .option("seed", [self.seed])
            .option("design", &self.design)
            .option("sessions", self.sessions)
            .option("speed", &self.speed)
            .option("shape", [&self.shape])
            .option("rig", [&self.rig])
            .paths("settings", &self.settings)
            .option("format", [&self.format])
    }
}
