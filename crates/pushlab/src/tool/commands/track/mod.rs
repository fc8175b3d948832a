//! `pushlab track`: pushes watched, and where they end foreseen better the longer they are.

mod picture;
mod result;
mod watched_push;

use std::path::PathBuf;

use anyhow::{Context, Result, bail, ensure};
use effects::{Channel, by_id};
use models::{Description, ModelFile, RecordedPush, Setup, Watched};
use report::{Page, Provenance, Section};

use self::picture::{film, picture};
use self::result::Tracked;
use self::watched_push::{WatchedPush, Watching};
use crate::tool::destination::folder;
use crate::tool::document::document;
use crate::tool::file_ending;
use crate::tool::origin::{Input, Origin, readable};
use crate::tool::step_size::StepSize;
use crate::tool::step_source::StepSource;
use crate::tool::terminal::Terminal;
use crate::tool::whole_pushes::WholePushes;

/// Watch pushes, and foresee their ends by what their beginnings tell
///
/// What differs from push to push in a model, such as where the center of friction is, shows in how the object
/// begins to move. A Kalman filter over pose and such numbers goes along the pusher's path and learns them from
/// the measured poses; the rest of the push is then foreseen with what was learnt, and without. How widely
/// pushes differ, and how long what was learnt stays true, is measured on the set's other pushes.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    #[command(flatten)]
    source: StepSource,
    /// Model file, with parameters that differ from push to push
    #[arg(long, value_name = "FILE", default_value = "model.toml",
          value_parser = file_ending::model)]
    model: PathBuf,
    /// Folder for tables, figures and the page; it may not have files in it
    #[arg(short, long, value_name = "DIR", value_parser = file_ending::folder)]
    output: PathBuf,
    /// Share of the pusher's way that is watched before the end is foreseen
    #[arg(long, value_name = "SHARE", default_value_t = 0.333, value_parser = share)]
    after: f64,
    /// Pushes that are drawn, of those that are watched
    #[arg(long, value_name = "N", default_value_t = 6,
          value_parser = clap::value_parser!(u32).range(0..=100))]
    films: u32,
    /// Length of a step of recordings: a time or a way, as of `simulate`; else 200ms
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true)]
    step: Option<StepSize>,
}

const EXAMPLES: &str = "\
Examples:
  pushlab track pushes --model better.toml -o watched
  pushlab track pushes --model better.toml --after 0.5 -o watched
where better.toml has parameters that differ from push to push:
  pushlab diagnose pushes --model model.toml -o diagnosis.json
  pushlab add --all --from diagnosis.json --model model.toml -o better.toml";

/// Fewer steps have no beginning and end.
const FEWEST_STEPS: usize = 3;

pub(crate) fn run(args: &Args, terminal: &Terminal) -> Result<()> {
    let inputs = args.source.inputs().with([&args.model]);
    let destination = folder(&args.output, &inputs)?;
    let mut origin = args.origin();
    readable(&args.model)?;
    origin.inputs.push(Input::file(&args.model)?);
    let file = ModelFile::read(&args.model)?;
    let set = WholePushes::of_steps(&args.source, args.step, &file, &mut origin, terminal)?;
    set.rig.warn_of_other(&args.model, &file, terminal);
    let setup = Setup { support: set.rig.support, own: Vec::new() };
    let chosen = chosen(&set);
    ensure!(!chosen.is_empty(), "no push of {FEWEST_STEPS} steps or more is left to watch");
    let description = of_motion(&file.description)?;
    ensure!(
        description.build_in(setup.support, &setup.own)?.n_drawn() > 0,
        "nothing differs from push to push in {}, so that a push tells nothing of its own: \
         `pushlab add --all --from DIAGNOSIS`, or `pushlab fit --per-push`",
        args.model.display()
    );
    let activity = terminal.activity();
    activity.tell("measuring on other pushes how widely they differ".to_owned());
    let mut others = set.others(&chosen, &file);
    others.retain(|push| push.steps.len() >= FEWEST_STEPS);
    let found = description.watched(&setup, &others, args.after);
    activity.finish();
    let found = found.context("cannot measure how widely pushes differ")?;
    let pushes = all_watched(args, &chosen, (&description, &setup), &found, terminal)?;
    let result = Tracked::new(&args.output, &file.name, (args.after, found), &pushes);
    let json = document(&origin, &terminal.warnings(), &result)?;
    let page = page(args, &result, &pushes, &origin)?;
    destination.fill(|part| -> Result<()> {
        part.write("track.json", json)?;
        part.write("index.html", page)?;
        for one in pushes.iter().filter(|one| !one.frames.is_empty()) {
            let figure = picture(one, one.n_seen);
            part.write(&format!("{}.svg", one.file_name()), figure.svg()?)?;
        }
        Ok(())
    })?;
    terminal.finish(&origin, &result, &result)
}

/// The model without what no motion shows.
fn of_motion(description: &Description) -> Result<Description> {
    let mut kept = description.clone();
    kept.effects.clear();
    for effect in &description.effects {
        if by_id(&effect.id)?.info().reaches.contains(&Channel::Motion) {
            kept.effects.push(effect.clone());
        }
    }
    Ok(kept)
}

/// Pushes that were kept from fits, where the model tells; else every second one.
fn chosen(set: &WholePushes) -> Vec<RecordedPush> {
    let every = if set.unseen.len() < set.all.len() { 1 } else { 2 };
    let long = set.unseen.iter().filter(|push| push.steps.len() >= FEWEST_STEPS);
    long.step_by(every).cloned().collect()
}

/// Pushes as they were watched; those that the model refuses are named and left out, as long as others go.
fn all_watched(
    args: &Args,
    chosen: &[RecordedPush],
    (description, setup): (&Description, &Setup),
    found: &Watched,
    terminal: &Terminal,
) -> Result<Vec<WatchedPush>> {
    let model = description.with(&found.calibration())?.build_in(setup.support, &setup.own)?;
    let watching = Watching { model: model.as_ref(), others: found, after: args.after };
    let n_films = (args.films as usize).min(chosen.len());
    let is_drawn = |k: usize| (0..n_films).any(|film| film * chosen.len() / n_films == k);
    let (mut watched, mut left_out) = (Vec::new(), Vec::new());
    let mut progress = terminal.progress("pushes watched:", chosen.len());
    for (k, push) in chosen.iter().enumerate() {
        match watching.watch(push, is_drawn(k)) {
            Ok(one) => watched.push(one),
            Err(error) => left_out.push(format!("{} ({error})", push.name)),
        }
        progress.advance();
    }
    progress.finish();
    if watched.is_empty() {
        bail!("no push can be watched: {}", left_out.join(", "));
    }
    if !left_out.is_empty() {
        let (n_out, n) = (left_out.len(), chosen.len());
        let told = left_out.join(", ");
        terminal.warn(format_args!("{n_out} of {n} pushes cannot be watched: {told}"));
    }
    Ok(watched)
}

/// The page of films.
fn page(args: &Args, result: &Tracked, pushes: &[WatchedPush], origin: &Origin) -> Result<String> {
    let input = |input: &Input| (input.path.display().to_string(), input.sha256.clone());
    let provenance = Provenance {
        tool: origin.tool.to_owned(),
        arguments: origin.command_line(),
        seed: None,
        inputs: origin.inputs.iter().map(input).collect(),
    };
    let lead = format!(
        "Where pushes of {} end, foreseen while they go on: with what their beginnings tell of \
         them, and without.",
        args.source.set.display()
    );
    let (head, rows) = result.table();
    let summary = Section::new("summary", "All pushes").text(&result.told()).table(&head, rows);
    let mut page = Page::new("Pushes watched", &lead, provenance).with(summary);
    for (k, one) in pushes.iter().filter(|one| !one.frames.is_empty()).enumerate() {
        let section = Section::new(&format!("push-{}", k + 1), &one.name);
        page = page.with(section.film(film(one)?));
    }
    Ok(page.single_file()?)
}

/// A share between 0 and 1.
fn share(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(share) if share > 0.0 && share < 1.0 => Ok(share),
        _ => Err("a share of the way is a number between 0 and 1, such as 0.333".to_owned()),
    }
}

impl Args {
    fn origin(&self) -> Origin {
        Origin::new("track")
            .path(&self.source.set)
            .paths("model", [&self.model])
            .option("after", [self.after])
            .option("films", [self.films])
            .option("step", self.step)
            .words(self.source.words())
    }
}
