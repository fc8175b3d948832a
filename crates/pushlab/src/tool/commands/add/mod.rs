//! `pushlab add`: a model with more effects: by hand, fitted to recordings, or from a diagnosis.

mod from_diagnosis;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use anyhow::{Result, bail, ensure};
use clap::ArgGroup;
use diagnosis::Diagnosis;
use effects::{EffectError, Setting, by_id};
use models::{ChannelModel, ModelEffect, ModelFile};
use output::OutputFile;

pub(super) use self::from_diagnosis::diagnosed_effect;

use self::from_diagnosis::{Asked, chosen, spread};
use super::models::Parameters;
use crate::tool::command_line::{effect_parser, seed_parser};
use crate::tool::destination::{Force, Inputs};
use crate::tool::diagnosis_file;
use crate::tool::file_ending;
use crate::tool::fitting::{FitOptions, Fitting, model_for};
use crate::tool::known::Known;
use crate::tool::origin::{Origin, TOOL};
use crate::tool::step_source::StepSource;
use crate::tool::suspected::warn;
use crate::tool::terminal::{TITLE, Terminal};
use crate::tool::wrong_usage::WrongUsage;

/// Add effects to a model: what a diagnosis names, or one with values by hand or fitted
///
/// With --from the effects that the diagnosis names, or EFFECT alone if it is one of them or of a
/// group of which one is missing; the pushes that confirmed them are the ones `compare` then uses.
/// With --fit a quarter of the pushes is held out first and kept for `compare`. An effect that the
/// pushes do not determine, or do not tell from nothing, is refused, with what would determine it.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES, group = ArgGroup::new("values").required(true))]
pub(crate) struct Args {
    /// Id of the effect, as `pushlab effects list` names it
    #[arg(required_unless_present = "from", value_parser = effect_parser(),
          hide_possible_values = true)]
    effect: Option<String>,
    /// A parameter's value in its SI unit; once for each parameter
    #[arg(long, value_name = "NAME=VALUE", group = "values")]
    set: Vec<Value>,
    /// Recording set, or step table, to fit the parameters to
    #[arg(long, value_name = "SET", group = "values", conflicts_with = "set")]
    fit: Option<PathBuf>,
    #[command(flatten)]
    known: Known,
    #[command(flatten)]
    options: FitOptions,
    /// Fit, too, by how much the effect's parameters differ from push to push and from place to place; EFFECT may be one that
    /// the model carries
    #[arg(long, requires = "fit")]
    per_push: bool,
    /// Answer of `pushlab diagnose` that names the effects and their values
    #[arg(long, value_name = "DIAGNOSIS", group = "values", value_parser = file_ending::json,
          conflicts_with_all = ["set", "fit"])]
    from: Option<PathBuf>,
    /// Of a diagnosis not only what is identified, but all that lowers the error: what it calls
    /// effective, too, and the first of each group that it cannot tell apart; what it found to differ
    /// from push to push does so in the model as well
    #[arg(long, requires = "from", conflicts_with = "effect")]
    all: bool,
    /// Model file to add to
    #[arg(long, value_name = "FILE", default_value = "model.toml",
          value_parser = file_ending::model)]
    model: PathBuf,
    /// Where to write the model with the effect; `-` is standard output
    #[arg(short, long, value_name = "FILE",
          value_parser = file_ending::or_standard(file_ending::model))]
    output: PathBuf,
    /// Seed of the choice of held-out pushes
    #[arg(long, value_name = "SEED", default_value_t = 7, value_parser = seed_parser())]
    seed: u64,
    #[command(flatten)]
    force: Force,
}

const EXAMPLES: &str = "\
Examples:
  pushlab add table-anisotropy --set ratio=1.3 --set direction=0.6 -o better.toml
  pushlab add table-anisotropy --fit pushes --model model.toml -o better.toml
  pushlab add support-points --fit table.csv --preset mit-table --model model.toml -o better.toml
  pushlab add pusher-friction --fit pushes --per-push --model model.toml -o better.toml
  pushlab add --from diagnosis.json --model model.toml -o better.toml
  pushlab add --all --from diagnosis.json --model model.toml -o better.toml
then:
  pushlab compare pushes --model better.toml --against model.toml";

/// A parameter's name and value.
#[derive(Clone, Debug)]
struct Value {
    name: String,
    value: f64,
}

impl FromStr for Value {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.split_once('=');
        let value = parts.and_then(|(name, value)| Some((name, value.trim().parse().ok()?)));
        let (name, value) = value.ok_or("expected NAME=VALUE with a number, such as ratio=1.3")?;
        Ok(Self { name: name.trim().to_owned(), value })
    }
}

pub(crate) fn run(args: &Args, terminal: &Terminal) -> Result<()> {
    let terminal = &terminal.beside([args.output.as_path()])?;
    let mut origin = args.origin();
    let inputs = Inputs::default().with(&args.from);
    if args.fit.is_none() && !args.known.words().is_empty() {
        bail!(WrongUsage(
            "--manifest, --preset and --mapping tell of what --fit reads; give --fit SET"
        ));
    }
    let source = args.fit.as_ref().map(|set| StepSource::of(set, args.known.clone()));
    let inputs = source.iter().fold(inputs, |inputs, source| inputs.and(source.inputs()));
    let output = (args.output.as_path(), &args.force);
    let (mut model, destination) = model_for(&args.model, output, inputs, &mut origin)?;
    let fitted: Vec<&str> =
        args.effect.as_deref().filter(|_| args.fit.is_some()).into_iter().collect();
    args.options.check(&fitted, &model)?;
    if let Some(from) = &args.from {
        return from_file(args, (from, model, origin), destination, terminal);
    }
    let about = by_id(args.effect())?.info();
    if let (true, Some(source)) = (args.per_push, &source) {
        return per_push(args, (source, model, origin), destination, terminal);
    }
    refuse_twice(&model, about.id)?;
    let name = format!("{} + {}", model.name, about.id);
    let Some(source) = &source else {
        return by_hand(args, ModelFile { name, ..model }, &origin, destination, terminal);
    };
    let fitting = Fitting::read((source, &args.options), &model, args.seed, &mut origin, terminal)?;
    let off = fitting.off(&model, about)?;
    model.description.effects.push(ModelEffect::from(Setting::new(about, &off)));
    let fit = fitting.fit(&model, &[about.id])?.distinct()?;
    let fitted = fitting.write(fit, name, (source, destination), terminal)?;
    terminal.finish(&origin, &fitted, &fitted)
}

/// An effect with the differences from push to push, and its values fitted with them.
fn per_push(
    args: &Args,
    (source, mut model, mut origin): (&StepSource, ModelFile, Origin),
    destination: OutputFile,
    terminal: &Terminal,
) -> Result<()> {
    let about = by_id(args.effect())?.info();
    let fitting = Fitting::read((source, &args.options), &model, args.seed, &mut origin, terminal)?;
    if !model.description.effects.iter().any(|effect| effect.id == about.id) {
        let off = fitting.off(&model, about)?;
        model.description.effects.push(ModelEffect::from(Setting::new(about, &off)));
        model.description = fitting.fit_values(&model, &[about.id])?.description;
    }
    let found = fitting.per_push(&model, about.id)?;
    let fit = found.fit.clone().determined()?;
    let name = format!("{} + {} per push", model.name, about.id);
    let fitted = fitting.write(fit, name, (source, destination), terminal)?.with_spread(&found);
    terminal.finish(&origin, &fitted, &fitted)
}

fn refuse_twice(model: &ModelFile, id: &str) -> Result<()> {
    let is_there = model.description.effects.iter().any(|effect| effect.id == id);
    ensure!(!is_there, EffectError::DuplicateEffect { effect: id.to_owned() });
    Ok(())
}

/// What a diagnosis names, with its values and with the parts of its set.
fn from_file(
    args: &Args,
    (from, mut model, mut origin): (&Path, ModelFile, Origin),
    destination: OutputFile,
    terminal: &Terminal,
) -> Result<()> {
    let found = diagnosis_file::read(from, &mut origin)?;
    if let Some(split) = model.split.as_ref().filter(|split| split.set != found.split.set) {
        bail!(
            "{} was fitted to other recordings (sha256:{:.12}…) than {} is of (sha256:{:.12}…); \
             diagnose the ones that it was fitted to",
            args.model.display(),
            split.set,
            from.display(),
            found.split.set
        );
    }
    let asked = match &args.effect {
        Some(id) => Asked::One(id),
        None if args.all => Asked::All,
        None => Asked::Identified,
    };
    let added = chosen(&found, &asked)?;
    warn(&found.suspicions, terminal);
    for effect in &added {
        refuse_twice(&model, &effect.id)?;
        model.name += &format!(" + {}", effect.id);
    }
    if model.split.is_none() && !is_of(&found, &origin) {
        let (model, from) = (args.model.display(), from.display());
        terminal.remark(format_args!(
            "{from} is about another model file than {model}; the values hold beside the one that \
             it is about"
        ));
    }
    model.description.effects.extend(added);
    if args.all {
        let (is_given, left_out) = spread(&mut model.description, &found)?;
        if is_given {
            model.name += " + scatter per push";
        }
        for id in left_out {
            terminal.remark(format_args!(
                "{id} differs from push to push, but the model does not say about which value; \
                 `pushlab add {id} --fit SET --per-push` fits both"
            ));
        }
    }
    model.split = Some(found.split);
    model.calibration = None;
    write(model, &origin, destination, terminal)
}

/// Whether the diagnosis is of the model that was read first.
fn is_of(found: &Diagnosis, origin: &Origin) -> bool {
    let inputs = found.made_by.iter().flat_map(|made| &made.inputs);
    let mut hashes = inputs.map(|input| input.sha256.as_str());
    origin.inputs.first().is_none_or(|model| hashes.any(|hash| hash == model.sha256))
}

/// Writes a model whose effects go together.
fn write(
    model: ModelFile,
    origin: &Origin,
    destination: OutputFile,
    terminal: &Terminal,
) -> Result<()> {
    // What cannot be together is refused before anything is written.
    let support = dataset::SupportSpec { friction: 0.25, gravity: 9.81 };
    ChannelModel::new(&model.description, support, &[])?;
    let path = destination.path().to_owned();
    model.write_to(destination)?;
    let parameters = Parameters::of(&model);
    let text = format!("{TITLE}wrote {}{TITLE:#}\n{parameters}", path.display());
    terminal.finish(origin, &parameters, text)
}

fn by_hand(
    args: &Args,
    mut model: ModelFile,
    origin: &Origin,
    destination: OutputFile,
    terminal: &Terminal,
) -> Result<()> {
    let mut parameters = BTreeMap::new();
    for Value { name, value } in &args.set {
        if parameters.insert(name.clone(), *value).is_some() {
            bail!(WrongUsage("a parameter has two values; give one"));
        }
    }
    let about = by_id(args.effect())?.info();
    let setting = Setting { id: about.id.to_owned(), parameters, ..Setting::default() };
    about.check(&setting.values(about)?)?;
    let mut effect = ModelEffect::from(setting);
    for estimate in effect.parameters.values_mut() {
        estimate.source = format!("by hand, {TOOL} {}", origin.command_line());
    }
    model.description.effects.push(effect);
    model.calibration = None;
    write(model, origin, destination, terminal)
}

impl Args {
    /// The effect asked for; the parser makes sure that there is one without `--from`.
    fn effect(&self) -> &str {
        self.effect.as_deref().unwrap_or_default()
    }

    fn origin(&self) -> Origin {
        let set = self.set.iter().map(|Value { name, value }| format!("{name}={value}"));
        Origin::new("add")
            .words(self.effect.clone())
            .option("set", set)
            .paths("fit", &self.fit)
            .option("seed", self.fit.as_ref().map(|_| self.seed))
            .words(self.per_push.then(|| "--per-push".to_owned()))
            .words(self.options.words())
            .words(self.known.words())
            .words(self.all.then(|| "--all".to_owned()))
            .paths("from", &self.from)
            .paths("model", [&self.model])
    }
}
