//! `pushlab models show`: what a model file says.

use std::path::PathBuf;
use std::sync::Arc;

use anyhow::{Result, bail};
use dataset::{MANIFEST_NAME, Manifest, ObjectChoice};
use models::{Base, ChannelModel, Description, ModelFile, rigid_object};

use super::parameters::{Parameter, Parameters};
use crate::tool::file_ending;
use crate::tool::origin::{Input, Origin, readable};
use crate::tool::terminal::Terminal;

/// Show what a model file says: kind, parameters, their errors and sources
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// Model file
    #[arg(default_value = "model.toml", value_parser = file_ending::model)]
    model: PathBuf,
    /// Manifest, or recording set, that says which object is pushed: to show, too, what the model makes of
    /// that object, its center of friction and its characteristic length c
    #[arg(long, value_name = "FILE")]
    manifest: Option<PathBuf>,
}

const EXAMPLES: &str = "\
Examples:
  pushlab models show model.toml
  pushlab models show model.toml --manifest pushes/dataset.toml
  pushlab models show model.toml --json";

pub(crate) fn run(args: &Args, terminal: &Terminal) -> Result<()> {
    readable(&args.model)?;
    let file = ModelFile::read(&args.model)?;
    let mut origin = Origin::new("models show").path(&args.model).paths("manifest", &args.manifest);
    origin.inputs.push(Input::file(&args.model)?);
    let mut parameters = Parameters::of(&file);
    if let Some(set) = &args.manifest {
        let path = if set.is_dir() { set.join(MANIFEST_NAME) } else { set.clone() };
        readable(&path)?;
        origin.inputs.push(Input::file(&path)?);
        parameters.parameters.extend(of_object(&file, &Manifest::read(&path)?)?);
    }
    terminal.finish(&origin, &parameters, &parameters)
}

/// Where the object of a set is held by friction, and how well against turning, by a model with mechanics.
fn of_object(file: &ModelFile, manifest: &Manifest) -> Result<Vec<Parameter>> {
    let base = match &file.description.base {
        Base::Analytical(base) | Base::Hybrid(base) => Base::Analytical(base.clone()),
        _ => bail!("a model without mechanics knows no center of friction; leave --manifest out"),
    };
    let ObjectChoice::Fixed(spec) = &manifest.object else {
        bail!("the objects of {} differ; --manifest needs one with one object", manifest.name);
    };
    let description = Description { base, weights: None, ..file.description.clone() };
    let model = ChannelModel::new(&description, manifest.support, &[])?;
    let (center, length) = model.center_and_length(&Arc::new(rigid_object(spec)?))?;
    let named = [
        ("center of friction x", center.x),
        ("center of friction y", center.y),
        ("characteristic length c", length),
    ];
    let told = named.map(|(name, value)| Parameter {
        name: format!("{name} under {}", spec.name),
        value: Some(value),
        se: 0.0,
        unit: "m",
        source: "follows from the model".to_owned(),
    });
    Ok(told.into())
}
