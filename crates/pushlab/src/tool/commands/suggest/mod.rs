//! `pushlab suggest`: the pushes to do next.

mod area;
mod list;
mod text;

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use clap::value_parser;
use diagnosis::{Aim, Diagnosis, SuggestSettings, Suggestion, suggest};
use models::ModelFile;
use serde::Serialize;

use self::area::Area;
use crate::tool::command_line::{effect_parser, seed_parser};
use crate::tool::destination::Force;
use crate::tool::diagnosis_file;
use crate::tool::file_ending;
use crate::tool::known::Known;
use crate::tool::origin::{Input, Origin, readable};
use crate::tool::speed::Speed;
use crate::tool::step_source::{Reading, StepSource, Steps};
use crate::tool::terminal::Terminal;

/// Tell which pushes to do next: those that decide between rivals, or measure a name
///
/// Candidates are drawn among the pushes that the rig can do: on any edge, at any angle and
/// orientation, where the object stays in the area that it covered. Of a group of which one effect
/// is missing those are chosen that drive the predictions of the worst told pair furthest apart;
/// else those that make the named effect's size most certain; with --for those that would show an
/// effect that was not testable. The list is read by `pushlab generate --design`, and by robots.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// Recording set that was diagnosed; else the one that the diagnosis names
    set: Option<PathBuf>,
    #[command(flatten)]
    known: Known,
    /// Answer of `pushlab diagnose`
    #[arg(long, value_name = "DIAGNOSIS", value_parser = file_ending::json)]
    from: PathBuf,
    /// Model file that was diagnosed; else the one that the diagnosis names
    #[arg(long, value_name = "FILE", value_parser = file_ending::model)]
    model: Option<PathBuf>,
    /// Number of pushes, repeats counted
    #[arg(short = 'n', long, value_name = "N", default_value_t = 20, alias = "n",
          value_parser = value_parser!(u32).range(1..=10_000))]
    pushes: u32,
    /// How often each push is done
    #[arg(long, value_name = "N", default_value_t = 5,
          value_parser = value_parser!(u32).range(1..=1000))]
    repeats: u32,
    /// Effect that the pushes are to show, such as one that is not testable with those so far
    #[arg(long = "for", value_name = "EFFECT", value_parser = effect_parser(),
          hide_possible_values = true)]
    target: Option<String>,
    /// Speeds to choose from, such as 20mm/s,100mm/s; else half of the slowest to twice the fastest
    #[arg(long, value_name = "SPEED", value_delimiter = ',')]
    speed: Vec<Speed>,
    /// Where the origin of the object's frame may be, in mm: XMIN,XMAX,YMIN,YMAX; else a square
    /// about where it was
    #[arg(long, value_name = "AREA", allow_hyphen_values = true)]
    area: Option<Area>,
    /// Seed of the candidates and of the order
    #[arg(long, value_name = "SEED", default_value_t = 7, value_parser = seed_parser())]
    seed: u64,
    /// The list of pushes, .csv; `-` is standard output
    #[arg(short, long, value_name = "FILE", default_value = "suggested.csv",
          value_parser = file_ending::or_standard(file_ending::csv))]
    output: PathBuf,
    #[command(flatten)]
    force: Force,
}

const EXAMPLES: &str = "\
Examples:
  pushlab suggest --from diagnosis.json -n 20 -o suggested.csv
  pushlab suggest pushes --from diagnosis.json --model model.toml --speed 10mm/s,100mm/s
  pushlab suggest --from diagnosis.json --for stream-latency --area -150,150,-100,100
then, to try them on the simulated rig:
  pushlab generate --shape pushes/dataset.toml --design suggested.csv -o twin";

/// The result for programs.
#[derive(Serialize)]
struct Suggested {
    list: PathBuf,
    /// The manifest of the rig that the pushes are for, where there is one.
    #[serde(skip)]
    rig: Option<PathBuf>,
    /// What the pushes are for: `rivals`, `precision` or `testable`.
    aim: &'static str,
    /// The groups of rivals, or the effects.
    effects: Vec<Vec<String>>,
    /// Pushes among which was chosen.
    n_feasible: usize,
    #[serde(flatten)]
    suggestion: Suggestion,
}

pub(crate) fn run(args: &Args, terminal: &Terminal) -> Result<()> {
    let terminal = &terminal.beside([args.output.as_path()])?;
    let mut origin = args.origin();
    let found = diagnosis_file::read(&args.from, &mut origin)?;
    let path = |given: &Option<PathBuf>, place: usize, what: &str| -> Result<PathBuf> {
        let named = || Some(found.made_by.as_ref()?.arguments.get(place)?.into());
        given.clone().or_else(named).with_context(|| {
            format!("{} does not tell which {what} it is about; name it", args.from.display())
        })
    };
    let (set, model) = (path(&args.set, SET, "set")?, path(&args.model, MODEL, "model")?);
    for path in [&set, &model] {
        readable(path)?;
    }
    let words = found.made_by.as_ref().map_or(&[][..], |made| &made.arguments);
    let source = StepSource::of(&set, args.known.clone().or_of(words));
    let destination = args.force.file(&args.output, &source.inputs().with([&args.from, &model]))?;
    origin.inputs.push(Input::file(&model)?);
    told_if_other(&found, &origin, &model, terminal);
    let model = ModelFile::read(&model)?;
    let Steps { observations: all, inputs, .. } = source.read(Reading::Steady, terminal)?;
    origin.arguments.extend(source.words().into_iter().filter(|_| args.known.words().is_empty()));
    origin.inputs.extend(inputs);
    ensure!(
        all.are_of(&found.split),
        "{} is about other recordings than {}; name the set that was diagnosed",
        args.from.display(),
        set.display()
    );
    let fitted = all.part(&found.split.fit)?;
    let (aim, known) = args.aim(&found)?;
    let suggestion = suggest(&fitted, &model.description, &known, &aim, &args.settings())?;
    destination.write(list::csv(&suggestion, &origin))?;
    let (name, effects) = match aim {
        Aim::Rivals(groups) => ("rivals", groups),
        Aim::Precision(ids) => ("precision", vec![ids]),
        Aim::Testable(ids) => ("testable", vec![ids]),
    };
    let (list, n_feasible) = (args.output.clone(), suggestion.feasible.len());
    let rig = source.manifest();
    let result = Suggested { list, rig, aim: name, effects, n_feasible, suggestion };
    terminal.finish(&origin, &result, &result)
}

/// Places of the set and of the model among the arguments that `diagnose` notes.
const SET: usize = 1;
const MODEL: usize = 3;

fn told_if_other(found: &Diagnosis, origin: &Origin, model: &Path, terminal: &Terminal) {
    let mut known = found.made_by.iter().flat_map(|made| &made.inputs);
    let hash = origin.inputs.last().map(|input| input.sha256.as_str());
    if !known.any(|input| Some(input.sha256.as_str()) == hash) {
        let model = model.display();
        terminal.remark(format_args!("the diagnosis is about another model file than {model}"));
    }
}

impl Args {
    /// What the pushes are for, and what is claimed besides.
    fn aim<'a>(&'a self, found: &'a Diagnosis) -> Result<(Aim, Vec<&'a str>)> {
        let named: Vec<&str> = found.identified.iter().map(String::as_str).collect();
        let Some(target) = self.target.as_deref() else {
            let aim = Aim::of(found).with_context(|| {
                let from = self.from.display();
                format!("{from} alone tells not what to push for; name an effect with --for EFFECT")
            })?;
            let known = if matches!(aim, Aim::Rivals(_)) { named } else { Vec::new() };
            return Ok((aim, known));
        };
        let firsts = found.ambiguous.iter().filter_map(|group| group.first());
        let known: Vec<&str> = named.iter().copied().chain(firsts.map(String::as_str)).collect();
        let ids = vec![target.to_owned()];
        Ok(match known.contains(&target) {
            true => (Aim::Precision(ids), known),
            false => (Aim::Testable(ids), known),
        })
    }

    fn settings(&self) -> SuggestSettings {
        SuggestSettings {
            n_pushes: self.pushes as usize,
            n_repeats: self.repeats as usize,
            seed: self.seed,
            speeds: self.speed.iter().map(|Speed(speed)| *speed).collect(),
            area: self.area.map(|Area(area)| area),
            ..SuggestSettings::default()
        }
    }

    fn origin(&self) -> Origin {
        Origin::new("suggest")
            .words(self.set.iter().map(|set| set.display().to_string()))
            .words(self.known.words())
            .paths("from", [&self.from])
            .paths("model", &self.model)
            .option("repeats", [self.repeats])
            .option("for", &self.target)
            .option("pushes", [self.pushes])
            .option("speed", &self.speed)
            .option("area", self.area)
            .option("seed", [self.seed])
    }
}
