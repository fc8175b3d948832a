//! `pushlab diagnose`: which physical effect a model lacks.

mod next_commands;
mod text;

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use dataset::Suspicion;
use diagnosis::{
    DiagnoseSettings, Diagnosis, MadeBy, MadeFrom, Observations, diagnose_with_progress,
};
use models::{ModelFile, Split};

use self::next_commands::next_commands;
pub(super) use self::text::write_error;
use crate::tool::command_line::seed_parser;
use crate::tool::destination::Force;
use crate::tool::document::indented;
use crate::tool::file_ending;
use crate::tool::origin::{Input, Origin, readable};
use crate::tool::recorded_steps::SET_FILES;
use crate::tool::step_source::{Reading, StepSource, Steps};
use crate::tool::suspected::warn_of_narrowness;
use crate::tool::terminal::Terminal;

/// Name the physical effect that a model lacks, or say that these recordings cannot tell
///
/// A quarter of the pushes is held out. On the others every effect of the catalogue is tested, the
/// likeliest are fitted together with the nominal numbers, and what is claimed has to predict the
/// held-out pushes better. The answer may be: these effects; one of these; none that is known;
/// none; or nothing that is sure.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    #[command(flatten)]
    source: StepSource,
    /// Model file
    #[arg(long, value_name = "FILE", default_value = "model.toml",
          value_parser = file_ending::model)]
    model: PathBuf,
    /// Where to write the answer as JSON (docs/diagnosis.schema.json); `-` is standard output
    #[arg(short, long, value_name = "FILE",
          value_parser = file_ending::or_standard(file_ending::json))]
    output: Option<PathBuf>,
    /// A second set that confirms what is fitted to all of the first, instead of a quarter of it
    #[arg(long, value_name = "SET")]
    confirm: Option<PathBuf>,
    /// Seed of the choice of held-out pushes
    #[arg(long, value_name = "SEED", default_value_t = 7, value_parser = seed_parser())]
    seed: u64,
    #[command(flatten)]
    force: Force,
}

const EXAMPLES: &str = "\
Examples:
  pushlab diagnose pushes --model model.toml
  pushlab diagnose pushes --model model.toml -o diagnosis.json
  pushlab diagnose pushes --confirm other-pushes
  pushlab diagnose mit-push-table/table.csv --preset mit-table --model mit.toml
  pushlab add --from diagnosis.json --model model.toml -o better.toml
  pushlab compare pushes --model better.toml --against model.toml";

pub(crate) fn run(args: &Args, terminal: &Terminal) -> Result<()> {
    let terminal = &terminal.beside(args.output.as_deref())?;
    let mut inputs = args.source.inputs().with([&args.model]);
    if let Some(second) = &args.confirm {
        inputs = inputs.and(args.source.of_same_kind(second).inputs());
    }
    let output = args.output.as_deref();
    let output = output.map(|output| args.force.file(output, &inputs)).transpose()?;
    let mut origin = args.origin();
    readable(&args.model)?;
    origin.inputs.push(Input::file(&args.model)?);
    let model = ModelFile::read(&args.model)?;
    let Steps { rig, observations, kind, inputs, n_pushes, mut suspicions, .. } =
        args.source.read(Reading::Steady, terminal)?;
    origin.inputs.extend(inputs);
    rig.warn_of_other(&args.model, &model, terminal);
    warn_of_narrowness(&observations, terminal);
    let confirm = match &args.confirm {
        Some(second) => Some(args.second(second, &mut origin, &mut suspicions, terminal)?),
        None => None,
    };
    let split = args.known_split(&model, &observations)?;
    let n_used = observations.pushes().len();
    let n_pushes_excluded = n_pushes.map_or(0, |n_pushes| n_pushes - n_used);
    let settings = DiagnoseSettings {
        split,
        confirm,
        seed: args.seed,
        n_pushes_excluded,
        ..DiagnoseSettings::default()
    };
    let activity = terminal.activity();
    let found = diagnose_with_progress(&observations, &model.description, &settings, &|phase| {
        activity.tell(phase);
    });
    activity.finish();
    let mut found = found?.diagnosis;
    if !suspicions.is_empty() {
        found.sentence =
            format!("Only if what may be wrong with these recordings is not: {}", found.sentence);
    }
    found.suspicions = suspicions;
    found.made_by = Some(made_by(&origin));
    found.warnings.iter().for_each(|warning| terminal.warn(warning));
    found.warnings = terminal.warnings();
    found.next = args.next_commands(&found)?;
    if let Some(output) = output {
        output.write(indented(&found)?)?;
    }
    let text = text::Answer {
        found: &found,
        model: &model.name,
        step: kind,
        is_kept: args.output.is_some(),
    };
    terminal.finish_with(&origin, || indented(&found), text)
}

fn made_by(origin: &Origin) -> MadeBy {
    let input = |input: &Input| MadeFrom {
        path: input.path.display().to_string(),
        sha256: input.sha256.clone(),
    };
    MadeBy {
        tool: origin.tool.to_owned(),
        arguments: origin.arguments.clone(),
        inputs: origin.inputs.iter().map(input).collect(),
    }
}

impl Args {
    /// How the pushes were split when the model was fitted to some of them.
    ///
    /// # Errors
    /// If none was kept, for another set confirmed what was fitted, and no set does now.
    fn known_split(&self, model: &ModelFile, observations: &Observations) -> Result<Option<Split>> {
        let split = model.split.clone().filter(|split| observations.are_of(split));
        if self.confirm.is_none() && split.as_ref().is_some_and(|one| one.confirm_set.is_some()) {
            bail!(
                "{} was fitted to all of {} and confirmed by another set; give that with --confirm",
                self.model.display(),
                self.source.set.display()
            );
        }
        Ok(split)
    }

    /// What to type next; pushes that no fit has seen are looked at.
    fn next_commands(&self, found: &Diagnosis) -> Result<Vec<String>> {
        let looked_at = self.confirm.as_ref().unwrap_or(&self.source.set);
        let source = [vec![looked_at.display().to_string()], self.source.words()].concat();
        let answer = self.output.as_deref().filter(|path| !file_ending::is_standard(path));
        let answer = answer.unwrap_or(Path::new("diagnosis.json"));
        next_commands(found, &source, &self.model, answer)
    }

    /// The set that confirms; none of its recordings may be one of those fitted to.
    fn second(
        &self,
        set: &Path,
        origin: &mut Origin,
        suspicions: &mut Vec<Suspicion>,
        terminal: &Terminal,
    ) -> Result<Observations> {
        let Steps { observations, inputs, suspicions: of_second, .. } =
            self.source.of_same_kind(set).read(Reading::Steady, terminal)?;
        suspicions.extend(of_second);
        let is_recording = |input: &&Input| {
            input.path.file_name().is_none_or(|name| !SET_FILES.iter().any(|file| *file == name))
        };
        let known: HashSet<&str> =
            origin.inputs.iter().filter(is_recording).map(|input| input.sha256.as_str()).collect();
        let shared = inputs.iter().filter(is_recording);
        if let Some(shared) = shared.into_iter().find(|one| known.contains(one.sha256.as_str())) {
            bail!(
                "{} is in {}, too: what was fitted to cannot confirm; leave it out of one of them",
                shared.path.display(),
                self.source.set.display()
            );
        }
        origin.inputs.extend(inputs);
        Ok(observations)
    }

    fn origin(&self) -> Origin {
        Origin::new("diagnose")
            .path(&self.source.set)
            .paths("model", [&self.model])
            .option("seed", [self.seed])
            .paths("confirm", &self.confirm)
            .words(self.source.words())
    }
}
