//! `cargo xtask diagnosis-trials`: how often the diagnosis is right.

mod case;
mod confusion;
mod detectable;
mod oracle;
mod page;
mod plan;
mod power;
mod queue;
mod quick;
mod record;
mod row;
mod rows;
mod scattering;
mod score;
mod trial;
mod truth;
mod variant;
mod wilson;

use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;
use std::time::Duration;

use anyhow::{Context, Result, bail, ensure};
use clap::ValueEnum;

use self::case::{Case, FIRST_REPORTED_SEED, Family};
use self::oracle::Oracle;
use self::queue::Queue;
use self::record::Record;
use fixtures::workspace_root;

/// Answer many recording sets with sealed truth, score the answers, write the table in docs/.
#[derive(clap::Args)]
pub struct Args {
    /// A few trials of a few minutes; fails if a verdict is broken
    #[arg(long, conflicts_with_all = ["families", "case"])]
    quick: bool,
    /// Go on with the results of an earlier run
    #[arg(long)]
    resume: bool,
    /// Trials at a time, each in a process of its own
    #[arg(short, long, value_name = "N", default_value_t = 2)]
    jobs: usize,
    /// Kinds of trials; all without it
    #[arg(long, value_enum, value_delimiter = ',')]
    families: Vec<Family>,
    /// First trials of each kind; all without it
    #[arg(short = 'n', long, value_name = "N")]
    first: Option<usize>,
    /// First seed: below 1000000 for development, which is not written to docs/
    #[arg(long, value_name = "SEED", default_value_t = FIRST_REPORTED_SEED)]
    seed: u64,
    /// Seconds after which a trial counts as wrong
    #[arg(long, value_name = "S", default_value_t = 900)]
    patience: u64,
    /// Run one trial again and print its answer
    #[arg(long, value_name = "NAME")]
    case: Option<String>,
    /// Write the record of that trial here
    #[arg(long, value_name = "FILE", hide = true)]
    record: Option<PathBuf>,
}

/// Where everything is kept, below the workspace.
const FOLDER: &str = "target/diagnosis-trials";
const PAGE: &str = "docs/diagnosis-trials.md";

/// Runs trials, or one of them.
///
/// # Errors
/// A set that cannot be made; with `--quick` a verdict that is broken.
pub fn run(args: &Args) -> Result<()> {
    let folder = workspace_root().join(FOLDER);
    fs::create_dir_all(&folder).with_context(|| format!("cannot create {}", folder.display()))?;
    let mut oracle = Oracle::open(&folder.join("oracle.json"))?;
    if let Some(name) = &args.case {
        return run_one(args, name, &mut oracle);
    }
    if args.quick {
        return quick::run(args.jobs, &folder);
    }
    let cases = args.cases();
    prepare(&cases, &mut oracle)?;
    let impossible = cases
        .iter()
        .filter_map(|case| plan::cannot_be(case, &oracle).map(|why| (case.name.clone(), why)));
    let impossible: Vec<(String, String)> = impossible.collect();
    let left_out: BTreeSet<&str> = impossible.iter().map(|(name, _)| name.as_str()).collect();
    let results = folder.join(format!("{}.jsonl", args.seed));
    if !args.resume && results.exists() {
        fs::remove_file(&results)?;
    }
    let known = record::read(&results)?;
    let done: BTreeSet<&str> = known.iter().map(|record| record.case.as_str()).collect();
    let is_open =
        |case: &&Case| !done.contains(case.name.as_str()) && !left_out.contains(case.name.as_str());
    let open: Vec<Case> = cases.iter().filter(is_open).cloned().collect();
    let queue = Queue {
        folder: &folder,
        results: &results,
        n_jobs: args.jobs.max(1),
        patience: Duration::from_secs(args.patience),
        seed: args.seed,
    };
    queue.run(&open)?;
    let records = record::read(&results)?;
    let page = page::Page {
        seed: args.seed,
        n_planned: n_planned(args.seed),
        impossible: &impossible,
        records: &records,
        oracle: &oracle,
    };
    let out = match args.seed {
        FIRST_REPORTED_SEED.. => workspace_root().join(PAGE),
        seed => folder.join(format!("{seed}.md")),
    };
    output::write(&out, page.text())?;
    println!("written: {}", out.display());
    Ok(())
}

/// Trials of the whole plan, of which a run may take a part.
fn n_planned(seed: u64) -> usize {
    Family::value_variants().iter().map(|family| plan::cases(*family, seed).len()).sum()
}

impl Args {
    fn cases(&self) -> Vec<Case> {
        let families = match self.families.as_slice() {
            [] => Family::value_variants(),
            some => some,
        };
        let first = self.first.unwrap_or(usize::MAX);
        let of = |family: &Family| plan::cases(*family, self.seed).into_iter().take(first);
        families.iter().flat_map(of).collect()
    }
}

/// Lets the oracle find every size that some cases need.
fn prepare(cases: &[Case], oracle: &mut Oracle) -> Result<()> {
    let mut setups: Vec<_> = cases.iter().filter(|case| case.needs_oracle()).collect();
    setups.sort_by_key(|case| case.setup);
    setups.dedup_by_key(|case| case.setup);
    setups.into_iter().try_for_each(|case| oracle.prepare(&case.setup))
}

fn run_one(args: &Args, name: &str, oracle: &mut Oracle) -> Result<()> {
    let all = Family::value_variants().iter().flat_map(|family| plan::cases(*family, args.seed));
    let planned = all.into_iter().find(|case| case.name == name);
    let case = match (planned, quick::cases().into_iter().find(|case| case.name == name)) {
        (Some(case), _) => {
            prepare(std::slice::from_ref(&case), oracle)?;
            case
        }
        // Of typical sizes, and judged without what the design can show.
        (None, Some(case)) => case,
        (None, None) => bail!("no trial is called {name}"),
    };
    let folder = queue::folder_of(&workspace_root().join(FOLDER), &case);
    if folder.exists() {
        fs::remove_dir_all(&folder)?;
    }
    let record = trial::run(&case, oracle, &folder)?;
    if let Some(path) = &args.record {
        output::write(path, serde_json::to_string(&record)?)?;
        return Ok(());
    }
    print!("{}", tell(&record)?);
    ensure!(record.outcome.answer().is_some(), "{}", record.outcome.text());
    Ok(())
}

/// A record for people.
fn tell(record: &Record) -> Result<String> {
    let mut text = format!("{} (seed {})\n", record.case, record.seed);
    for effect in &record.truth {
        text += &format!("hidden:   {} {:?}\n", effect.id, effect.values);
    }
    text += &format!("answer:   {} ({:.1} s)\n", record.outcome.text(), record.seconds);
    if let Some(answer) = record.outcome.answer() {
        text += &format!("sentence: {}\n", answer.sentence);
        text += &format!("leftover: {}\n", serde_json::to_string(&answer.leftover)?);
        if let Some(remains) = &answer.remains {
            text += &format!("remains:  {}\n", serde_json::to_string(remains)?);
        }
        text += &format!("error:    {}\n", serde_json::to_string(&answer.error)?);
        for effect in answer.effects.iter().filter(|effect| effect.is_told()) {
            text += &format!("  {}\n", serde_json::to_string(effect)?);
        }
    }
    for (variant, outcome) in &record.variants {
        text += &format!("with {}: {}\n", variant.name(), outcome.text());
    }
    if let Some(floor) = record.floor {
        text += &format!("floor:    {floor:?}\n");
    }
    for (id, closed) in &record.closed_by_hand {
        text += &format!("by hand:  {id} closes {:.0} %\n", 100.0 * closed);
    }
    let score = score::Score::of(record);
    text += &format!("score:    found {:?}, wrong {:?}\n", score.found, score.wrong);
    Ok(text)
}
