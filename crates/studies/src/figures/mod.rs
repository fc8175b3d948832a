//! `cargo xtask reproduce-figures`: the thesis' figures, computed anew, on one offline page.

mod catalogue;
mod claims;
mod comparison;
pub(crate) mod inputs;
mod lacking;
pub(crate) mod learning;
mod mechanics;
mod missing;
pub(crate) mod models;
mod motion;
mod quartiles;
mod recordings;
mod seed;
mod sketch;
mod thesis_design;

use std::fs;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use indicatif::{ProgressBar, ProgressStyle};
use plant::Profile;
use rayon::ThreadPoolBuilder;
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use report::{Claim, Page, Plate, Provenance, Section};

use catalogue::{ALL, Chapter, Entry};
use fixtures::workspace_root;
use inputs::Inputs;
use lacking::Lacking;
use sketch::Sketch;

pub(crate) use thesis_design::{named, rigs, thesis_design};

/// Draw the thesis' figures on one offline page.
#[derive(clap::Args)]
pub struct Args {
    /// Draw only these figures, by number (2.9,5.7)
    #[arg(long, value_delimiter = ',', value_name = "NUMBER")]
    only: Vec<String>,
    /// Recording set or table of steps to draw from; without it the thesis' design, simulated once
    #[arg(long, value_name = "PATH")]
    data: Option<PathBuf>,
    /// How rough the simulated rig of the thesis' design is
    #[arg(long, value_name = "NAME", default_value = Profile::DEFAULT, value_parser = rigs())]
    rig: String,
    /// The 60 pushes of fixtures/pushes, fewer repetitions and fewer steps to learn from, for a first look
    #[arg(long)]
    quick: bool,
    /// Folder for the page, the pictures and their numbers
    #[arg(short, long, value_name = "DIR", default_value = "target/figures", alias = "out")]
    output: PathBuf,
    /// Figures drawn at once, one for each core without it
    #[arg(short, long, value_name = "N")]
    jobs: Option<NonZeroUsize>,
}

/// Draws the figures and writes `index.html`.
///
/// # Errors
/// An unknown number, data that cannot be read, or a figure that failed, by its number.
pub fn run(args: &Args) -> Result<()> {
    let entries = choose(&args.only)?;
    let inputs = match &args.data {
        Some(path) => Inputs::open(path, args.quick)?,
        None if args.quick || !entries.iter().any(|entry| entry.chapter.needs_data()) => {
            Inputs::fixtures(args.quick)?
        }
        None => Inputs::at_speeds(&thesis_design(named(&args.rig)?)?)?,
    };
    let out = workspace_root().join(&args.output);
    fs::create_dir_all(&out).with_context(|| format!("cannot create {}", out.display()))?;
    let outcomes = draw_all(&entries, &inputs, &out, args.jobs)?;
    let drawn = outcomes.iter().filter(|outcome| matches!(outcome, Outcome::Drawn(..))).count();
    page(&entries, outcomes, &inputs, args)?.write(&out)?;
    println!("{drawn} of {} figures on {}", entries.len(), out.join("index.html").display());
    Ok(())
}

fn choose(only: &[String]) -> Result<Vec<&'static Entry>> {
    if let Some(unknown) = only.iter().find(|id| !ALL.iter().any(|entry| entry.id == **id)) {
        let known: Vec<_> = ALL.iter().map(|entry| entry.id).collect();
        bail!("there is no figure `{unknown}`; there are {}", known.join(", "));
    }
    Ok(ALL.iter().filter(|e| only.is_empty() || only.iter().any(|id| id == e.id)).collect())
}

/// What became of a figure.
enum Outcome {
    /// Its plate, and the claims that it settles.
    Drawn(Box<Plate>, Vec<Claim>),
    /// What the data lack for it.
    Lacking(String),
}

/// The outcomes of all entries, in their order whatever the number of jobs.
fn draw_all(
    entries: &[&Entry],
    inputs: &Inputs,
    out: &Path,
    jobs: Option<NonZeroUsize>,
) -> Result<Vec<Outcome>> {
    let pool = ThreadPoolBuilder::new().num_threads(jobs.map_or(0, NonZeroUsize::get)).build()?;
    let style = ProgressStyle::with_template("{bar:30} {pos}/{len} figures {msg}")?;
    let bar = ProgressBar::new(entries.len() as u64).with_style(style);
    let drawn: Vec<_> = pool.install(|| {
        let draw = |entry: &&Entry| {
            let result = draw(entry, inputs, out);
            bar.inc(1);
            bar.set_message(entry.id);
            result.with_context(|| format!("figure {}", entry.id))
        };
        entries.par_iter().map(draw).collect::<Result<_>>()
    })?;
    bar.finish_and_clear();
    Ok(drawn)
}

/// Every claim as these data settle it, in the order of the figures; a figure that fails on them settles
/// none, and its claims tell why.
///
/// # Errors
/// If no threads can be started.
pub(crate) fn settled(inputs: &Inputs) -> Result<Vec<Claim>> {
    let settling: Vec<_> = ALL.iter().filter(|entry| !entry.claims.is_empty()).collect();
    let settle = |entry: &&Entry| match sketch(entry, inputs) {
        Ok(Ok(sketch)) => sketch.claims,
        Ok(Err(lacking)) => entry.untestable(&lacking),
        Err(error) => entry.untestable(&format!("figure {}: {error:#}", entry.id)),
    };
    // In a pool of their own, as they wait for what is ingested in the common one.
    let pool = ThreadPoolBuilder::new().build()?;
    let claims: Vec<Vec<Claim>> = pool.install(|| settling.par_iter().map(settle).collect());
    Ok(claims.into_iter().flatten().collect())
}

/// A figure, or what the data lack for it.
fn sketch(entry: &Entry, inputs: &Inputs) -> Result<Result<Sketch, String>> {
    match (entry.draw)(inputs) {
        Ok(sketch) => Ok(Ok(sketch)),
        Err(error) => Ok(Err(error.downcast::<Lacking>()?.to_string())),
    }
}

fn draw(entry: &Entry, inputs: &Inputs, out: &Path) -> Result<Outcome> {
    let sketch = match sketch(entry, inputs)? {
        Ok(sketch) => sketch,
        Err(lacking) => return Ok(Outcome::Lacking(lacking)),
    };
    let Sketch { figure, data, caption, alt, claims } = sketch;
    let figure = figure.named(&format!("Figure {}: {}", entry.id, entry.title));
    let name = format!("figure-{}", entry.id.replace('.', "-").to_lowercase());
    let drawn = figure.write(out, &name, &data)?;
    let command = format!("cargo xtask reproduce-figures --only {}", entry.id);
    Ok(Outcome::Drawn(Box::new(Plate::new(drawn, &caption, &command).alt(&alt)), claims))
}

fn page(entries: &[&Entry], outcomes: Vec<Outcome>, inputs: &Inputs, args: &Args) -> Result<Page> {
    ensure!(entries.len() == outcomes.len(), "a figure is missing");
    let provenance = Provenance {
        tool: format!("pushlab {}", env!("CARGO_PKG_VERSION")),
        arguments: arguments(args),
        seed: Some(inputs::SEED),
        inputs: inputs.sources(),
    };
    let lead = format!(
        "The figures of the thesis on data-driven planar pushing, computed anew. Each stands \
         beside the numbers it was drawn from and the command that draws it alone. Data: {}.",
        inputs.name()
    );
    let mut page = Page::new("Planar pushing: the figures", &lead, provenance);
    let (mut plates, mut settled, mut lacking) = (Vec::new(), Vec::new(), Vec::new());
    for (entry, outcome) in entries.iter().zip(outcomes) {
        match outcome {
            Outcome::Drawn(plate, own) => {
                plates.push((entry.chapter, plate));
                settled.extend(own);
            }
            Outcome::Lacking(reason) => {
                settled.extend(entry.untestable(&reason));
                lacking.push(vec![format!("{}: {}", entry.id, entry.title), reason]);
            }
        }
    }
    for chapter in Chapter::ALL {
        let own: Vec<_> = plates.extract_if(.., |(of, _)| *of == chapter).collect();
        if own.is_empty() {
            continue;
        }
        let section = Section::new(chapter.anchor(), chapter.title());
        page = page.with(own.into_iter().fold(section, |to, (_, plate)| to.figure(*plate)));
    }
    if !lacking.is_empty() {
        page = page.with(
            Section::new("not-drawn", "Not drawn from these data")
                .table(&["figure", "reason"], lacking),
        );
    }
    Ok(page.with(claims::section(settled)))
}

fn arguments(args: &Args) -> String {
    let mut words = vec!["reproduce-figures".to_owned()];
    if !args.only.is_empty() {
        words.push(format!("--only {}", args.only.join(",")));
    }
    if let Some(data) = &args.data {
        words.push(format!("--data {}", data.display()));
    }
    if args.data.is_none() && !args.quick {
        words.push(format!("--rig {}", args.rig));
    }
    if args.quick {
        words.push("--quick".to_owned());
    }
    words.join(" ")
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use clap::Parser;

    use super::{ALL, Args, Entry, choose, run};

    #[derive(Parser)]
    struct CommandLine {
        #[command(flatten)]
        args: Args,
    }

    /// Runs the task as from the command line; its files by name.
    fn drawn(words: &[&str], out: &Path) -> Vec<(String, Vec<u8>)> {
        let out = out.to_str().expect("a temporary folder has a plain name");
        let line = CommandLine::try_parse_from([&["figures", "--output", out], words].concat());
        run(&line.unwrap().args).unwrap();
        let mut files: Vec<_> = fs::read_dir(out)
            .unwrap()
            .map(|entry| entry.unwrap().path())
            .map(|path| (path.file_name().unwrap().display().to_string(), fs::read(path).unwrap()))
            .collect();
        files.sort();
        files
    }

    /// Figures that take longest, whose own tests draw them.
    const ELSEWHERE: [&str; 3] = ["M.4", "M.9", "M.11"];

    #[test]
    fn every_figure_leaves_a_light_picture_its_numbers_and_its_place_on_the_page() {
        let folder = tempfile::tempdir().unwrap();
        let here: Vec<&Entry> = ALL.iter().filter(|entry| !ELSEWHERE.contains(&entry.id)).collect();
        let ids: Vec<&str> = here.iter().map(|entry| entry.id).collect();
        let files = drawn(&["--quick", "--only", &ids.join(",")], folder.path());
        let page = fs::read_to_string(folder.path().join("index.html")).unwrap();
        // The fixtures have one speed alone; this figure is drawn in its own test.
        let (lacking, drawn): (Vec<&Entry>, Vec<&Entry>) =
            here.into_iter().partition(|entry| entry.id == "5.6");
        assert!(page.contains("the same pushes at several speeds"), "5.6 does not say why");
        assert!(lacking[0].claims.iter().all(|claim| page.contains(claim)), "claims are left out");
        for entry in drawn {
            let name = format!("figure-{}", entry.id.replace('.', "-").to_lowercase());
            let size = |extension: &str| {
                let file = format!("{name}.{extension}");
                files.iter().find(|(name, _)| *name == file).map_or(0, |(_, bytes)| bytes.len())
            };
            assert!((1..200_000).contains(&size("svg")), "{name}.svg: {} bytes", size("svg"));
            assert!(size("png") > 10_000, "{name}.png: {} bytes", size("png"));
            assert!(size("csv") + size("json") > 100, "{name}: no numbers");
            assert!(page.contains(&format!("<figure id=\"{name}\">")), "{name} is not on the page");
            assert!(page.contains(&format!("--only {}</code>", entry.id)), "{name}: no command");
        }
        assert!(page.contains("3. c of the uniform square"));
    }

    #[test]
    fn chosen_figures_have_the_same_bytes_for_any_number_of_jobs() {
        let (one, two) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let chosen = ["--only", "2.10,2.5,3.2", "--jobs"];
        let alone = drawn(&[&chosen[..], &["1"]].concat(), one.path());
        let names: Vec<_> = alone.iter().map(|(name, _)| name.as_str()).collect();
        let drawn_names = ["figure-2-10", "figure-2-5", "figure-3-2"];
        let expected = drawn_names.map(|name| [format!("{name}.png"), format!("{name}.svg")]);
        assert!(expected.iter().flatten().all(|name| names.contains(&name.as_str())), "{names:?}");
        assert_eq!(names.len(), 3 * 3 + 1, "{names:?}");
        assert!(alone == drawn(&[&chosen[..], &["2"]].concat(), two.path()));
    }

    #[test]
    fn an_unknown_number_is_refused_with_the_known_ones() {
        let message = choose(&["9.9".into()]).unwrap_err().to_string();
        assert!(message.contains("`9.9`") && message.contains("2.9"), "{message}");
    }

    #[test]
    fn numbers_are_chosen_in_the_order_of_the_thesis() {
        let chosen = choose(&["2.9".into(), "2.5".into()]).unwrap();
        assert_eq!(chosen.iter().map(|entry| entry.id).collect::<Vec<_>>(), ["2.5", "2.9"]);
        assert_eq!(choose(&[]).unwrap().len(), ALL.len());
    }
}
