//! `pushlab check`: what recordings can and cannot tell, before any fit.

mod text;

use std::path::PathBuf;

use anyhow::Result;
use dataset::{Manifest, RecordingSet, Suspicion};
use diagnosis::{
    Coverage, LookAlikes, NoiseModel, NotTestable, Observations, Screen, ScreenSettings,
    ScreenedEffect, screen, steady_ingest,
};
use effects::{Channel, by_id};
use models::{Description, Estimate, ModelFile};
use serde::Serialize;

use crate::file_ending;
use crate::origin::{Input, Origin, readable};
use crate::recorded_steps::RecordedSteps;
use crate::suspected::{suspected, warn, warn_of_narrowness};
use crate::terminal::Terminal;

/// Tell what a set can and cannot show, before any model is fitted to it
///
/// Where the pushes lie, which channels there are, how far pushes scatter and why; and for each
/// effect the smallest size that these data would show, or why they cannot show it and what to
/// measure. Nothing is said about which effects are there.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// Recording set: a folder with dataset.toml
    set: PathBuf,
    /// The model that effects would be added to; else the analytical one with nominal values
    #[arg(long, value_name = "FILE", value_parser = file_ending::model)]
    model: Option<PathBuf>,
}

const EXAMPLES: &str = "\
Examples:
  pushlab check pushes
  pushlab check pushes --model model.toml
  pushlab check pushes --json";

/// What a set can tell.
#[derive(Serialize)]
struct Checked {
    /// Title of the set.
    name: String,
    /// The model that effects would be added to.
    model: String,
    /// What of the recordings contradicts the mechanics: frames, signs, units.
    suspicions: Vec<Suspicion>,
    coverage: Coverage,
    /// From the first step to the end of the last, in s.
    duration: f64,
    /// Rows of the table that are not used, by reason.
    excluded: String,
    channels: Vec<Channel>,
    noise: NoiseModel,
    /// Pushes that the effects are looked for in: all, or an even choice of a large set.
    n_pushes_screened: usize,
    effects: Vec<Showable>,
    /// Pairs of effects that these data hardly tell apart.
    look_alikes: Vec<LookAlikes>,
}

/// What a set could show of an effect.
#[derive(Serialize)]
struct Showable {
    id: &'static str,
    title: &'static str,
    /// Why it cannot be tested.
    not_testable: Option<NotTestable>,
    coordinates: Vec<Size>,
}

/// The size of one coordinate that would be found in nine of ten sets.
#[derive(Serialize)]
struct Size {
    name: &'static str,
    unit: &'static str,
    detection_limit: f64,
}

pub(crate) fn run(args: &Args, terminal: &Terminal) -> Result<()> {
    let mut origin = args.origin();
    readable(&args.set)?;
    let set = RecordingSet::open(&args.set)?;
    let manifest = set.manifest();
    let (model, description) = match &args.model {
        Some(path) => {
            readable(path)?;
            origin.inputs.push(Input::file(path)?);
            let file = ModelFile::read(path)?;
            (file.name, file.description)
        }
        None => ("the nominal model".to_owned(), nominal(manifest)?),
    };
    let suspicions = suspected(&set);
    warn(&suspicions, terminal);
    let RecordedSteps { table, inputs, .. } =
        RecordedSteps::read(&set, &steady_ingest(), terminal)?;
    origin.inputs.extend(inputs);
    let observations = Observations::steady(&table, manifest)?;
    warn_of_narrowness(&observations, terminal);
    let noise = NoiseModel::learn(&description, &[], &observations)?;
    let settings = ScreenSettings::default();
    let found = screen(&description, &[], &observations, &noise, &settings)?;
    let start = table.rows.iter().map(|row| row.t).fold(f64::INFINITY, f64::min);
    let end = table.rows.iter().map(|row| row.t + row.dt).fold(start, f64::max);
    let result = Checked {
        name: manifest.name.clone(),
        model,
        suspicions,
        coverage: Coverage::of(&observations),
        duration: end - start,
        excluded: observations.excluded().to_string(),
        channels: observations.channels(),
        noise,
        n_pushes_screened: found.n_pushes,
        effects: showable(&found),
        look_alikes: found.look_alikes,
    };
    terminal.finish(&origin, &result, &result)
}

fn nominal(manifest: &Manifest) -> Result<Description> {
    let Manifest { pusher, object, object_support, .. } = manifest;
    let friction = Estimate::exact(pusher.friction, "manifest");
    Ok(Description::nominal(friction, object, object_support, "manifest")?)
}

/// The effects in the order of the catalogue.
fn showable(found: &Screen) -> Vec<Showable> {
    let of = |effect: &ScreenedEffect| {
        let size = |coordinate: &diagnosis::ScreenedCoordinate| Size {
            name: coordinate.name,
            unit: coordinate.unit,
            detection_limit: coordinate.detection_limit,
        };
        Showable {
            id: effect.id,
            title: by_id(effect.id).map_or("", |known| known.info().title),
            not_testable: effect.not_testable.clone(),
            coordinates: effect.coordinates.iter().map(size).collect(),
        }
    };
    let place =
        |effect: &Showable| effects::all().iter().position(|known| known.info().id == effect.id);
    let mut list: Vec<_> = found.effects.iter().map(of).collect();
    list.sort_by_key(place);
    list
}

impl Args {
    fn origin(&self) -> Origin {
        Origin::new("check").path(&self.set).paths("model", &self.model)
    }
}
