//! `pushlab report`: how models do on recordings, on one page that needs nothing else.

mod diagnosed;
mod errors;
mod friction;
mod groups;
mod headline;
mod learning;
mod maps;
mod measure;
mod outlines;
mod parameters;
mod pushes;
mod steps;
mod tried;

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use ::report::{Page, Provenance};
use anyhow::{Context, Result, bail};
use dataset::Suspicion;
use diagnosis::{Diagnosis, Footprints, MapSettings, NoiseFloor, Observations};
use models::ModelFile;
use serde::Serialize;

use self::diagnosed::Signatures;
use self::headline::Headline;
use self::tried::{Trial, Tried};
use super::compare::{Part, floor_about};
use crate::tool::destination::Force;
use crate::tool::diagnosis_file;
use crate::tool::file_ending;
use crate::tool::origin::{Input, Origin, readable};
use crate::tool::step_kind::StepKind;
use crate::tool::step_size::StepSize;
use crate::tool::step_source::{Reading, StepSource, Steps};
use crate::tool::terminal::Terminal;

/// Show how models do on recordings: one HTML page, to be read without a network
///
/// The page has errors against the noise floor, where each model fails, every push as measured and
/// as predicted, the models' parameters, and how it was made.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    #[command(flatten)]
    source: StepSource,
    /// Model file; several may be given, the first is the one that others are seen beside
    #[arg(long, value_name = "FILE", default_value = "model.toml",
          value_parser = file_ending::model)]
    model: Vec<PathBuf>,
    /// The page; `-` is standard output
    #[arg(short, long, value_name = "PAGE", default_value = "report.html",
          value_parser = file_ending::or_standard(file_ending::page))]
    output: PathBuf,
    /// Answer of `pushlab diagnose` about this set and the first model: what is missing
    #[arg(long, value_name = "DIAGNOSIS", alias = "diagnosis", value_parser = file_ending::json)]
    from: Option<PathBuf>,
    /// Length of a step, of all that is in contact: a time (200ms, 0.2s) or a way of the pusher (4mm, 0.4cm);
    /// else 5mm of smoothed motion, away from vertices
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true)]
    step: Option<StepSize>,
    #[command(flatten)]
    force: Force,
}

const EXAMPLES: &str = "\
Examples:
  pushlab report pushes --model model.toml -o report.html
  pushlab report pushes --model model.toml --model better.toml -o report.html
  pushlab report pushes --model model.toml --from diagnosis.json -o report.html
  pushlab report pushes --step 4mm --json
  pushlab report plywood.csv --preset mit-endpoints --shape hex --model mit.toml";

/// What is compared, and on what.
struct Report {
    set: String,
    part: Part,
    floor: NoiseFloor,
    /// What a step is of which errors are told.
    step: StepKind,
    /// The pushes that no model was fitted to, by which errors are compared.
    observations: Observations,
    /// Those that maps and the player show.
    all: Observations,
    /// All their steps in contact, near vertices too: for whole pushes, and for the outline.
    in_contact: Observations,
    models: Vec<Tried>,
    /// Of all pushes of the set.
    footprints: Footprints,
    diagnosis: Option<(Diagnosis, Signatures)>,
    /// What of the set contradicts the mechanics.
    suspicions: Vec<Suspicion>,
}

/// The result for programs.
#[derive(Serialize)]
struct Written {
    page: PathBuf,
    bytes: usize,
    models: Vec<String>,
    n_pushes: usize,
    n_steps: usize,
    /// Pushes that the page can play.
    n_played: usize,
    /// Pushes of the maps, of which it plays those.
    n_shown: usize,
    suspicions: Vec<Suspicion>,
    headlines: Vec<Headline>,
}

pub(crate) fn run(args: &Args, terminal: &Terminal) -> Result<()> {
    let terminal = &terminal.beside([args.output.as_path()])?;
    let files = args.model.iter().chain(&args.from);
    let inputs = args.source.inputs().with(files);
    let destination = args.force.file(&args.output, &inputs)?;
    let mut origin = args.origin();
    let mut files = Vec::new();
    for path in &args.model {
        readable(path)?;
        origin.inputs.push(Input::file(path)?);
        files.push((path.as_path(), ModelFile::read(path)?));
    }
    let diagnosis = args.from.as_ref();
    let diagnosis = diagnosis.map(|path| diagnosis_file::read(path, &mut origin)).transpose()?;
    let mut steps = args.source.read(Reading::looked_at(args.step), terminal)?;
    origin.inputs.append(&mut steps.inputs);
    if let Some(path) = args.from.as_ref().filter(|_| {
        diagnosis.as_ref().is_some_and(|found| !steps.observations.are_of(&found.split))
    }) {
        bail!("{} is about other recordings than {}", path.display(), args.source.set.display());
    }
    files.iter().for_each(|(path, file)| steps.rig.warn_of_other(path, file, terminal));
    let report = Report::of(steps, files)?.with_diagnosis(diagnosis)?;
    let (html, written) = report.written(&origin, &args.output)?;
    destination.write(html)?;
    terminal.finish(&origin, &written, &written)
}

impl Report {
    fn of(steps: Steps, files: Vec<(&Path, ModelFile)>) -> Result<Self> {
        let Steps { rig, observations: all, kind: step, in_contact, suspicions, .. } = steps;
        let part = Part::of(files.iter().filter_map(|(_, file)| file.split.as_ref()), &all);
        let footprints = Footprints::of(&all);
        let observations = part.observations(all.clone())?;
        let floor = lowest_floor(&files, &all, &observations)?;
        let floor = floor.context("name a model with --model")?;
        let in_contact = match in_contact {
            // A push without a step that is compared is none here.
            Some(found) => {
                found.part(&all.pushes().iter().map(ToString::to_string).collect::<Vec<_>>())?
            }
            None => all.clone(),
        };
        let names = distinct_names(&files);
        let trial = Trial {
            all: &all,
            unseen: &observations,
            in_contact: &in_contact,
            part: &part,
            floor: &floor,
        };
        let mut models = Vec::new();
        for ((path, file), name) in files.into_iter().zip(names) {
            let tried = trial.of(name, file);
            models.push(tried.with_context(|| format!("cannot try {}", path.display()))?);
        }
        Ok(Self {
            set: rig.name,
            part,
            floor,
            step,
            observations,
            all,
            in_contact,
            models,
            footprints,
            diagnosis: None,
            suspicions,
        })
    }

    /// The same with what a diagnosis says of the first model.
    fn with_diagnosis(mut self, diagnosis: Option<Diagnosis>) -> Result<Self> {
        let Some(found) = diagnosis else { return Ok(self) };
        let signatures = Signatures::of(&found, &self.models[0], &self.all, &self.floor)?;
        self.diagnosis = Some((found, signatures));
        Ok(self)
    }

    /// The page, and what programs want to know of it.
    fn written(&self, origin: &Origin, page: &Path) -> Result<(String, Written)> {
        let headlines = Headline::all(self);
        let player = pushes::player(self);
        let n_played = player.n_embedded();
        let mut html = Page::new(
            &format!("{}: models and measurements", self.set),
            &self.lead(),
            made_by(origin),
        )
        .with(headline::section(self, &headlines));
        if let Some((found, signatures)) = &self.diagnosis {
            html = html.with(diagnosed::section(found, signatures)?);
        }
        html = html
            .with(errors::section(self)?)
            .with(pushes::section(player))
            .with(outlines::section(self)?);
        if let Some(friction) = friction::section(self)? {
            html = html.with(friction);
        }
        html = html.with(maps::section(self)?).with(parameters::section(self));
        if let Some(learning) = learning::section(self)? {
            html = html.with(learning);
        }
        let html = html.single_file()?;
        let written = Written {
            page: page.to_owned(),
            bytes: html.len(),
            models: self.models.iter().map(|model| model.name.clone()).collect(),
            n_pushes: self.observations.pushes().len(),
            n_steps: self.observations.n_steps(),
            n_played,
            n_shown: self.models[0].rollouts.len(),
            suspicions: self.suspicions.clone(),
            headlines,
        };
        Ok((html, written))
    }

    fn lead(&self) -> String {
        let (pushes, steps) = (self.all.pushes().len(), self.all.n_steps());
        let name = |(index, model): (usize, &Tried)| format!("{} – {}", tag(index), model.name);
        let names: Vec<_> = self.models.iter().enumerate().map(name).collect();
        format!(
            "{steps} steps of {pushes} pushes, and what models make of them: {}.",
            names.join("; ")
        )
    }
}

/// One floor for all models: about the one that leaves the least between like pushes.
fn lowest_floor(
    files: &[(&Path, ModelFile)],
    all: &Observations,
    unseen: &Observations,
) -> Result<Option<NoiseFloor>> {
    let mut lowest: Option<NoiseFloor> = None;
    for (path, file) in files {
        let floor = floor_about(&file.description, all, unseen)
            .with_context(|| format!("cannot try {}", path.display()))?;
        if lowest.as_ref().is_none_or(|lowest| floor.times(lowest) < 1.0) {
            lowest = Some(floor);
        }
    }
    Ok(lowest)
}

/// The letter by which charts name a model.
fn tag(index: usize) -> String {
    let letter = char::from(b'A' + (index % 26) as u8).to_string();
    if index < 26 { letter } else { format!("{letter}{}", index / 26) }
}

fn made_by(origin: &Origin) -> Provenance {
    let input = |input: &Input| (input.path.display().to_string(), input.sha256.clone());
    Provenance {
        tool: origin.tool.to_owned(),
        arguments: origin.command_line(),
        seed: Some(MapSettings::default().seed),
        inputs: origin.inputs.iter().map(input).collect(),
    }
}

/// The models' names; with the file where another model has the same.
fn distinct_names(files: &[(&Path, ModelFile)]) -> Vec<String> {
    let mut known = HashSet::new();
    let twice: HashSet<&str> = files
        .iter()
        .map(|(_, file)| file.name.as_str())
        .filter(|name| !known.insert(*name))
        .collect();
    let name = |(path, file): &(&Path, ModelFile)| {
        if twice.contains(file.name.as_str()) {
            format!("{} ({})", file.name, path.display())
        } else {
            file.name.clone()
        }
    };
    files.iter().map(name).collect()
}

impl std::fmt::Display for Written {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { page, n_shown, n_played, .. } = self;
        self.headlines.iter().try_for_each(|headline| write!(f, "{headline}"))?;
        let played = if n_played == n_shown {
            "all pushes can be played".to_owned()
        } else {
            format!("{n_played} of {n_shown} pushes can be played")
        };
        writeln!(f, "wrote {} ({:.1} MB, {played})", page.display(), self.bytes as f64 / 1e6)
    }
}

impl Args {
    fn origin(&self) -> Origin {
        Origin::new("report")
            .path(&self.source.set)
            .words(self.source.words())
            .paths("model", &self.model)
            .paths("from", &self.from)
            .option("step", self.step)
    }
}
