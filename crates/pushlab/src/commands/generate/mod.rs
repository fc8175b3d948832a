//! `pushlab generate`: a recording set from the simulated rig, with a sealed truth.

mod design_name;
mod generated;
mod speed;

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use anyhow::{Context, Result, bail};
use clap::builder::PossibleValuesParser;
use clap::value_parser;
use dataset::all_writers;
use planar::MIT_NAMES;
use plant::{Design, GenerateSettings, Hidden, Layout, PushedObject, generate_each};

use self::design_name::DesignName;
use self::generated::Generated;
use self::speed::Speed;
use crate::destination::Destination;
use crate::failure::WrongUsage;
use crate::origin::{Input, Origin};
use crate::progress::Progress;
use crate::terminal::Terminal;

/// Simulate pushes and write them as a recording set that can hide an effect
///
/// A rig with dynamics, made independently of the models: a measured-looking set for which the truth
/// is known. The truth goes to OUT.truth.toml beside the set, which no other command reads; a
/// surprise is told nowhere else. `pushlab effects list` names what can be hidden.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// Folder of the new set; it may not have files in it
    out: PathBuf,
    /// Hide this effect, 'ID' or 'ID: NAME=VALUE, …', or a `surprise`; may be given several times
    #[arg(long, value_name = "EFFECT")]
    hidden: Vec<String>,
    /// Number of pushes; else 200, or all of the thesis' design or of a file
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..=1_000_000))]
    pushes: Option<u32>,
    /// Seed of everything random
    #[arg(long, value_name = "SEED", default_value_t = 7)]
    seed: u64,
    /// Which pushes: random, thesis, narrow, repeats, or a FILE.csv with one push a line
    #[arg(long, value_name = "DESIGN", default_value = "random")]
    design: DesignName,
    /// The pusher's speeds to choose from, such as 20mm/s or 20mm/s,100mm/s; else 20mm/s
    #[arg(long, value_name = "SPEED", value_delimiter = ',')]
    speed: Vec<Speed>,
    /// The object: one of the MIT push data set's
    #[arg(long, value_name = "NAME", default_value = "rect1", hide_possible_values = true,
          value_parser = PossibleValuesParser::new(MIT_NAMES))]
    shape: String,
    /// How recordings are written
    #[arg(long, value_name = "FORMAT", default_value = "mcap-ros2", value_parser = format_parser())]
    format: String,
}

const EXAMPLES: &str = "\
Examples:
  pushlab generate set --hidden 'table-anisotropy: ratio=1.3, direction_deg=34'
  pushlab generate set --hidden surprise --pushes 400 --seed 12
  pushlab generate set --design thesis --shape tri1 --format csv
  pushlab generate set --design pushes.csv --hidden table-tilt --hidden pusher-radius";

fn format_parser() -> PossibleValuesParser {
    PossibleValuesParser::new(all_writers().iter().map(|writer| writer.id()))
}

pub(crate) fn run(args: &Args, terminal: &Terminal) -> Result<()> {
    let settings = args.settings()?;
    let mut origin = args.origin();
    if let DesignName::File(path) = &args.design {
        origin.inputs.push(Input::file(path)?);
    }
    let progress: Mutex<Option<Progress>> = Mutex::new(None);
    let report = generate_each(&settings, &args.out, |n_pushes| {
        let mut progress = progress.lock().unwrap_or_else(PoisonError::into_inner);
        progress.get_or_insert_with(|| terminal.progress("pushes made:", n_pushes)).advance();
    });
    if let Some(progress) = progress.into_inner().unwrap_or_else(PoisonError::into_inner) {
        progress.finish();
    }
    let report = report?;
    mark(&report.sealed_truth, &origin)?;
    let result = Generated::new(&report, args);
    terminal.finish(&origin, &result, &result)
}

/// Adds what made the set to its truth: the set itself must not tell what it hides.
fn mark(sealed_truth: &Path, origin: &Origin) -> Result<()> {
    let text = std::fs::read_to_string(sealed_truth)
        .with_context(|| format!("cannot read {}", sealed_truth.display()))?;
    Destination::new(sealed_truth)?.write((text + "\n" + &origin.comment()).as_bytes())
}

impl Args {
    fn settings(&self) -> Result<GenerateSettings> {
        let hidden =
            self.hidden.iter().map(|text| Ok(text.parse()?)).collect::<Result<Vec<Hidden>>>()?;
        let mut design = Design { layout: self.design.layout()?, ..Design::default() };
        if matches!(design.layout, Layout::Thesis | Layout::List(_)) {
            design.n_pushes = 0;
            if !self.speed.is_empty() {
                bail!(WrongUsage("this design has its own speeds: leave out --speed"));
            }
        }
        if let Some(n_pushes) = self.pushes {
            design.n_pushes = n_pushes as usize;
        }
        if !self.speed.is_empty() {
            design.speeds = self.speed.iter().map(|Speed(speed)| *speed).collect();
        }
        Ok(GenerateSettings {
            name: format!("simulated pushes of {}", self.shape),
            object: PushedObject::Mit { name: self.shape.clone() },
            hidden,
            design,
            format: self.format.clone(),
            seed: self.seed,
            ..GenerateSettings::default()
        })
    }

    /// What decides the result.
    fn origin(&self) -> Origin {
        let mut words = vec!["generate".to_owned()];
        let mut option = |name: &str, value: String| words.extend([format!("--{name}"), value]);
        for effect in &self.hidden {
            option("hidden", effect.clone());
        }
        if let Some(n_pushes) = self.pushes {
            option("pushes", n_pushes.to_string());
        }
        option("seed", self.seed.to_string());
        option("design", self.design.to_string());
        for speed in &self.speed {
            option("speed", speed.to_string());
        }
        option("shape", self.shape.clone());
        option("format", self.format.clone());
        Origin::new(words)
    }
}
