//! `pushlab add`: a model with one more effect, by hand or fitted to recordings.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::str::FromStr;

use anyhow::{Result, bail};
use clap::ArgGroup;
use effects::{EffectError, Setting, by_id};
use models::{ChannelModel, ModelEffect, ModelFile};

use super::models::Parameters;
use crate::destination::Destination;
use crate::failure::WrongUsage;
use crate::file_ending;
use crate::fitting::{Fitting, model_for};
use crate::origin::{Origin, TOOL};
use crate::terminal::{TITLE, Terminal};

/// Add an effect to a model, with values by hand or fitted to recordings
///
/// With --fit a quarter of the pushes is set aside first and kept for `compare`. An effect that the
/// pushes do not determine, or do not tell from nothing, is refused, with what would determine it.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES, group = ArgGroup::new("values").required(true))]
pub(crate) struct Args {
    /// Id of the effect, as `pushlab effects list` names it
    effect: String,
    /// A parameter's value in its SI unit; once for each parameter
    #[arg(long, value_name = "NAME=VALUE", group = "values")]
    set: Vec<Value>,
    /// Recording set to fit the parameters to
    #[arg(long, value_name = "SET", group = "values", conflicts_with = "set")]
    fit: Option<PathBuf>,
    /// Model file to add to
    #[arg(long, value_name = "FILE", default_value = "model.toml",
          value_parser = file_ending::model)]
    model: PathBuf,
    /// Where to write the model with the effect
    #[arg(short, long, value_name = "FILE", value_parser = file_ending::model)]
    output: PathBuf,
    /// Seed of the choice of pushes that are set aside
    #[arg(long, value_name = "SEED", default_value_t = 7, value_parser = clap::value_parser!(u32))]
    seed: u32,
}

const EXAMPLES: &str = "\
Examples:
  pushlab add table-anisotropy --set ratio=1.3 --set direction=0.6 -o better.toml
  pushlab add table-anisotropy --fit pushes --model model.toml -o better.toml
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
    let mut origin = args.origin();
    let (mut model, destination) = model_for(&args.model, &args.output, &mut origin)?;
    let about = by_id(&args.effect)?.about();
    if model.description.effects.iter().any(|effect| effect.id == about.id) {
        bail!(EffectError::Twice { effect: about.id.to_owned() });
    }
    let name = format!("{} + {}", model.name, about.id);
    let Some(set) = &args.fit else {
        return by_hand(args, ModelFile { name, ..model }, &origin, &destination, terminal);
    };
    let fitting = Fitting::read(set, &model, args.seed.into(), &mut origin, terminal)?;
    let off = fitting.off(&model, about)?;
    model.description.effects.push(ModelEffect::from(Setting::new(about, &off)));
    let fit = fitting.fit(&model, &[about.id])?.distinct()?;
    let fitted = fitting.write(fit, name, &destination)?;
    terminal.finish(&origin, &fitted, &fitted)
}

fn by_hand(
    args: &Args,
    mut model: ModelFile,
    origin: &Origin,
    destination: &Destination,
    terminal: &Terminal,
) -> Result<()> {
    let mut parameters = BTreeMap::new();
    for Value { name, value } in &args.set {
        if parameters.insert(name.clone(), *value).is_some() {
            bail!(WrongUsage("a parameter has two values; give one"));
        }
    }
    let setting = Setting { id: args.effect.clone(), parameters };
    let about = by_id(&args.effect)?.about();
    about.check(&setting.values(about)?)?;
    let mut effect = ModelEffect::from(setting);
    for estimate in effect.parameters.values_mut() {
        estimate.source = format!("by hand, {TOOL} {}", origin.command_line());
    }
    model.description.effects.push(effect);
    // What cannot be together is refused before anything is written.
    let support = dataset::SupportSpec { friction: 0.25, gravity: 9.81 };
    ChannelModel::new(&model.description, support, &[])?;
    model.write(destination.path())?;
    let parameters = Parameters::of(&model);
    let text = format!("{TITLE}wrote {}{TITLE:#}\n{parameters}", destination.path().display());
    terminal.finish(origin, &parameters, text)
}

impl Args {
    fn origin(&self) -> Origin {
        let mut words = vec!["add".to_owned(), self.effect.clone()];
        for Value { name, value } in &self.set {
            words.extend(["--set".to_owned(), format!("{name}={value}")]);
        }
        if let Some(set) = &self.fit {
            words.extend(["--fit".to_owned(), set.display().to_string()]);
            words.extend(["--seed".to_owned(), self.seed.to_string()]);
        }
        words.extend(["--model".to_owned(), self.model.display().to_string()]);
        Origin::new(words)
    }
}
