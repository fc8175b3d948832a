//! `pushlab models init`: the thesis' analytical model with a manifest's nominal values.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use clap::builder::PossibleValuesParser;
use dataset::{
    MANIFEST_NAME, Manifest, ObjectChoice, ObjectSupport, Preset, TableMapping, is_end_points,
};
use models::{Description, Estimate, ModelFile};
use planar::MIT_NAMES;

use super::parameters::Parameters;
use crate::command_line::preset_parser;
use crate::destination::{Force, Inputs};
use crate::file_ending;
use crate::origin::{Input, Origin, TOOL, readable};
use crate::step_source::open_set;
use crate::terminal::{TITLE, Terminal};
use crate::wrong_usage::WrongUsage;

/// Write the analytical model with the nominal values of a recording set
///
/// The quasi-static push with the pusher's friction from the manifest, on the limit surface of what the
/// manifest says that the object rests on: the ellipsoid of uniform pressure if it says nothing.
/// Poses before and after pushes do not tell what was pushed: name --preset, or the folder of a manifest.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// Recording set, or its dataset.toml; a file of poses before and after pushes with --preset
    #[arg(required_unless_present = "preset")]
    set: Option<PathBuf>,
    /// Take the nominal values of a public data set, whatever a manifest says
    #[arg(long, value_name = "NAME", value_parser = preset_parser())]
    preset: Option<Preset>,
    /// Of public data about several shapes, this one
    #[arg(long, value_name = "NAME", value_parser = PossibleValuesParser::new(MIT_NAMES),
          requires_all = ["preset", "set"])]
    shape: Option<String>,
    /// Where to write the model; `-` is standard output
    #[arg(short, long, value_name = "FILE", default_value = "model.toml",
          value_parser = file_ending::or_standard(file_ending::model))]
    output: PathBuf,
    #[command(flatten)]
    force: Force,
}

const EXAMPLES: &str = "\
Examples:
  pushlab models init pushes
  pushlab models init pushes/dataset.toml -o nominal.toml
  pushlab models init --preset mit-push -o mit.toml
  pushlab models init plywood.csv --preset mit-endpoints --shape hex -o mit.toml";

pub(crate) fn run(args: &Args, terminal: &Terminal) -> Result<()> {
    let terminal = terminal.beside([args.output.as_path()])?;
    let with = |inputs: Inputs, set: &PathBuf| inputs.with_set(set, args.preset);
    let inputs = args.set.iter().fold(Inputs::default(), with);
    let destination = args.force.file(&args.output, &inputs)?;
    let mut origin = Origin::new("models init")
        .words(args.set.iter().map(|set| set.display().to_string()))
        .option("preset", args.preset.map(Preset::name))
        .option("shape", &args.shape);
    let nominal = match (&args.set, args.preset) {
        (None, Some(preset)) => Nominal::of_preset(preset)?,
        (Some(set), Some(preset)) => {
            readable(set)?;
            match preset {
                Preset::MitTable => Nominal::of_preset(preset)?,
                // Of a preset for recordings, these have to be some.
                _ => {
                    let set = open_set(set, args.preset, args.shape.as_deref())?;
                    Nominal::of(set.manifest().clone(), format!("preset {}", preset.name()))
                }
            }
        }
        (Some(set), None) => {
            let path = if set.is_dir() { set.join(MANIFEST_NAME) } else { set.clone() };
            readable(&path)?;
            if is_end_points(&path) {
                open_set(&path, None, None)?;
            }
            let nominal = Nominal::of_manifest(&path)?;
            origin.inputs.push(Input::file(&path)?);
            nominal
        }
        (None, None) => bail!(WrongUsage("name a recording set or a preset")),
    };
    let file = nominal.model(&origin)?;
    file.write_to(destination)?;
    let parameters = Parameters::of(&file);
    let text = format!("{TITLE}wrote {}{TITLE:#}\n{parameters}", args.output.display());
    terminal.finish(&origin, &parameters, text)
}

/// What the model needs of a set.
struct Nominal {
    name: String,
    pusher_friction: f64,
    object: ObjectChoice,
    object_support: ObjectSupport,
    source: String,
}

impl Nominal {
    fn of_manifest(path: &Path) -> Result<Self> {
        Ok(Self::of(Manifest::read(path)?, path.display().to_string()))
    }

    fn of(manifest: Manifest, source: String) -> Self {
        let Manifest { name, pusher, object, object_support, .. } = manifest;
        Self { name, pusher_friction: pusher.friction, object, object_support, source }
    }

    fn of_preset(preset: Preset) -> Result<Self> {
        let source = format!("preset {}", preset.name());
        if preset == Preset::MitTable {
            let TableMapping { name, pusher, object, object_support, .. } =
                TableMapping::mit_table()?;
            let object = ObjectChoice::Fixed(Box::new(object));
            let pusher_friction = pusher.friction;
            return Ok(Self { name, pusher_friction, object, object_support, source });
        }
        let missing = WrongUsage("this preset has no nominal values; name another");
        Ok(Self::of(preset.manifest().ok_or(missing)??, source))
    }

    /// The analytical model, whose friction says where it comes from and what wrote it.
    fn model(&self, origin: &Origin) -> Result<ModelFile> {
        let hashes = origin.inputs.iter().map(|input| format!(" sha256:{}", input.sha256));
        let hashes = hashes.collect::<String>();
        let source = format!("{}{hashes}, by {TOOL} {}", self.source, origin.command_line());
        let friction = Estimate::exact(self.pusher_friction, &source);
        let (object, support) = (&self.object, &self.object_support);
        let description = Description::nominal(friction, object, support, &source)?;
        let name = format!("nominal model of {}", self.name);
        Ok(ModelFile { name, description, split: None })
    }
}
