//! `pushlab check`: what recordings can and cannot tell, before any fit.

mod text;

use std::path::PathBuf;

use anyhow::Result;
use dataset::Suspicion;
use diagnosis::{
    Covariate, Coverage, LookAlikes, NoiseModel, NotTestable, Screen, ScreenSettings,
    ScreenedEffect, screen,
};
use effects::{Channel, by_id};
use models::ModelFile;
use serde::Serialize;

use crate::tool::file_ending;
use crate::tool::origin::{Input, Origin, readable};
use crate::tool::step_source::{Reading, StepSource, Steps};
use crate::tool::suspected::warn_of_narrowness;
use crate::tool::terminal::Terminal;

/// Tell what a set can and cannot show, before any model is fitted to it
///
/// Where the pushes lie, which channels there are, how far pushes scatter and why; and for each
/// effect the smallest size that these data would show, or why they cannot show it and what to
/// measure. Nothing is said about which effects are there.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    #[command(flatten)]
    source: StepSource,
    /// The model that effects would be added to; else the analytical one with nominal values
    #[arg(long, value_name = "FILE", value_parser = file_ending::model)]
    model: Option<PathBuf>,
}

const EXAMPLES: &str = "\
Examples:
  pushlab check pushes
  pushlab check pushes --model model.toml
  pushlab check steps.csv --manifest pushes/dataset.toml
  pushlab check table.csv --preset mit-table
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
    /// From the first step to the end of the last, in s; none where the rows of a table do not tell.
    duration: Option<f64>,
    /// Rows of the table that are not used, by reason.
    excluded: String,
    channels: Vec<Channel>,
    /// What the rows of a table do not tell: the numbers of its coverage say nothing then.
    unknown: Vec<Covariate>,
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
    let file = match &args.model {
        Some(path) => {
            readable(path)?;
            origin.inputs.push(Input::file(path)?);
            Some((path, ModelFile::read(path)?))
        }
        None => None,
    };
    let Steps { rig, observations, inputs, suspicions, duration, .. } =
        args.source.read(Reading::Look, terminal)?;
    origin.inputs.extend(inputs);
    let (model, description) = match file {
        Some((path, file)) => {
            rig.warn_of_other(path, &file, terminal);
            (file.name, file.description)
        }
        None => ("the nominal model".to_owned(), rig.nominal("manifest")?),
    };
    warn_of_narrowness(&observations, terminal);
    let noise = NoiseModel::learn(&description, &[], &observations)?;
    let settings = ScreenSettings::default();
    let found = screen(&description, &[], &observations, &noise, &settings)?;
    let result = Checked {
        name: rig.name,
        model,
        suspicions,
        coverage: Coverage::of(&observations),
        duration,
        excluded: observations.excluded().to_string(),
        channels: observations.channels(),
        unknown: observations.unknown().to_vec(),
        noise,
        n_pushes_screened: found.n_pushes,
        effects: showable(&found),
        look_alikes: found.look_alikes,
    };
    terminal.finish(&origin, &result, &result)
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
        Origin::new("check")
            .path(&self.source.set)
            .paths("model", &self.model)
            .words(self.source.words())
    }
}
