//! `pushlab models init`: the thesis' analytical model with a manifest's nominal values.

use std::path::PathBuf;

use anyhow::{Result, bail};
use dataset::{Preset, TableMapping};
use models::ModelFile;

use super::parameters::Parameters;
use crate::tool::destination::Force;
use crate::tool::file_ending;
use crate::tool::known::Known;
use crate::tool::opened::open_rig;
use crate::tool::origin::{Input, Origin, TOOL};
use crate::tool::rig::Rig;
use crate::tool::step_source::StepSource;
use crate::tool::terminal::{TITLE, Terminal};
use crate::tool::wrong_usage::WrongUsage;

/// Write the analytical model with the nominal values of a recording set or a step table
///
/// The quasi-static push with the pusher's friction from the manifest, on the limit surface of what the
/// manifest says that the object rests on: the ellipsoid of uniform pressure if it says nothing. Of a table
/// of others its mapping says both.
/// Poses before and after pushes do not tell what was pushed: name --preset, or the folder of a manifest.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// Recording set or its dataset.toml, a step table, or the mapping of a table; with --preset a file of
    /// poses before and after pushes, or nothing
    #[arg(required_unless_present_any = ["preset", "manifest", "mapping"])]
    set: Option<PathBuf>,
    #[command(flatten)]
    known: Known,
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
  pushlab models init steps.csv --manifest pushes/dataset.toml
  pushlab models init theirs.csv --mapping mapping.toml
  pushlab models init --preset mit-push -o mit.toml
  pushlab models init plywood.csv --preset mit-endpoints --shape hex -o mit.toml";

pub(crate) fn run(args: &Args, terminal: &Terminal) -> Result<()> {
    let terminal = terminal.beside([args.output.as_path()])?;
    let set = args.set.as_ref().or(args.known.manifest.as_ref()).or(args.known.mapping.as_ref());
    let inputs = set.map(|set| StepSource::of(set, args.known.clone()).inputs());
    let destination = args.force.file(&args.output, &inputs.unwrap_or_default())?;
    let mut origin = Origin::new("models init")
        .words(args.set.iter().map(|set| set.display().to_string()))
        .words(args.known.words());
    let (rig, inputs, source) = args.rig()?;
    origin.inputs.extend(inputs);
    let file = nominal(&rig, &source, &origin)?;
    file.write_to(destination)?;
    let parameters = Parameters::of(&file);
    let text = format!("{TITLE}wrote {}{TITLE:#}\n{parameters}", args.output.display());
    terminal.finish(&origin, &parameters, text)
}

/// The analytical model, whose friction says where it comes from and what wrote it.
fn nominal(rig: &Rig, source: &str, origin: &Origin) -> Result<ModelFile> {
    let hashes = origin.inputs.iter().map(|input| format!(" sha256:{}", input.sha256));
    let hashes = hashes.collect::<String>();
    let source = format!("{source}{hashes}, by {TOOL} {}", origin.command_line());
    let name = format!("nominal model of {}", rig.name);
    let made_for = Some(rig.made_for());
    Ok(ModelFile { made_for, ..ModelFile::new(name, rig.nominal(&source)?) })
}

impl Args {
    /// What was pushed, with what was read for it and where that stands.
    fn rig(&self) -> Result<(Rig, Vec<Input>, String)> {
        let Known { manifest, preset, mapping, shape } = &self.known;
        match (&self.set, manifest.as_ref().or(mapping.as_ref()), preset) {
            (Some(set), ..) => open_rig(set, &self.known),
            (None, Some(file), _) => open_rig(file, &Known::default()),
            (None, None, Some(_)) if shape.is_some() => {
                bail!(WrongUsage("--shape is for the pushes of a file; name it"))
            }
            (None, None, Some(preset)) => of_preset(*preset),
            (None, None, None) => bail!(WrongUsage("name a recording set, a table or a preset")),
        }
    }
}

/// The nominal values of public data, which need not be there.
fn of_preset(preset: Preset) -> Result<(Rig, Vec<Input>, String)> {
    let rig = match preset.manifest() {
        Some(manifest) => Rig::from(&manifest?),
        None => Rig::from(&TableMapping::mit_table()?),
    };
    Ok((rig, Vec::new(), format!("preset {}", preset.name())))
}
