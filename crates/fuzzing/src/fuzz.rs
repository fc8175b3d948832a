//! `cargo xtask fuzz`: damaged inputs for every public reader, and what must never come of them.
//!
//! A reader is one file of `readers/` and one line of its list. Inputs are made from small valid
//! ones, and case I of a seed is the same input on every run. They are read in processes of their
//! own, so that whatever ends one is known by its case. Readers are compiled as for tests, where
//! overflows of integers panic.

use std::fs;
use std::hint::black_box;
use std::panic::{catch_unwind, set_hook, take_hook};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use anyhow::{Context, Result, ensure};

use crate::case::{Fault, Kind};
use crate::reader::Reader;
use crate::readers::{READERS, by_name};
use crate::scratch::Scratch;
use crate::watch::{Outcome, run_input, run_order};
use crate::worker::Order;
use crate::{keep, minimize, mutate, table, worker};

/// Longest time that a reader may take for one input, in s, on a machine with other work.
const TIME_LIMIT: f64 = 20.0;
/// The same while a failure is made smaller.
const SHORT_TIME_LIMIT: f64 = 4.0;

/// Read damaged inputs with every reader; those on which one fails are kept
#[derive(clap::Args)]
pub struct Args {
    /// Readers to test, all without it
    #[arg(long = "reader", value_name = "NAME", value_delimiter = ',')]
    readers: Vec<String>,
    /// Time for each reader, in s; 10 without --cases
    #[arg(long, value_name = "N")]
    seconds: Option<f64>,
    /// Inputs for each reader
    #[arg(short = 'n', long, value_name = "N")]
    cases: Option<u64>,
    /// Seed of all inputs
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    seed: u64,
    /// Read this case alone, and print what comes of it
    #[arg(long, value_name = "I", requires = "readers", conflicts_with_all = ["cases", "seconds"])]
    case: Option<u64>,
    /// First case
    #[arg(long, value_name = "I", default_value_t = 0, alias = "from")]
    first_case: u64,
    /// Processes at a time, as many as the machine has cores without it
    #[arg(short, long, value_name = "N")]
    jobs: Option<usize>,
    /// Read the kept inputs alone
    #[arg(long, conflicts_with_all = ["cases", "seconds", "case"])]
    replay: bool,
    /// Longest time for one input, in s
    #[arg(long, value_name = "N", default_value_t = TIME_LIMIT)]
    time_limit: f64,
    /// Folder of the kept inputs, fixtures/fuzz without it
    #[arg(long, value_name = "DIR")]
    keep: Option<PathBuf>,
    /// Print the readers
    #[arg(long)]
    list: bool,
}

/// Read inputs in this process, for `cargo xtask fuzz`
#[derive(clap::Args)]
pub struct WorkerArgs {
    dir: PathBuf,
    #[arg(long)]
    reader: String,
    #[arg(long)]
    input: Option<PathBuf>,
    #[arg(long, default_value_t = 0)]
    seed: u64,
    #[arg(long, default_value_t = 0)]
    first: u64,
    #[arg(long, default_value_t = 1)]
    stride: u64,
    #[arg(long, default_value_t = 0)]
    end: u64,
    #[arg(long, default_value_t = 0.0)]
    seconds: f64,
}

/// Does a worker's order.
///
/// # Errors
/// If it cannot be begun.
pub fn work(args: &WorkerArgs) -> Result<()> {
    let reader = by_name(&args.reader)?;
    if let Some(input) = &args.input {
        return worker::replay(reader, &args.dir, &fs::read(input)?);
    }
    let WorkerArgs { seed, first, stride, end, seconds, .. } = *args;
    worker::work(reader, &args.dir, &Order { seed, first, stride, end, seconds })
}

impl Args {
    fn chosen(&self) -> Result<Vec<&'static dyn Reader>> {
        if self.readers.is_empty() {
            return Ok(READERS.to_vec());
        }
        self.readers.iter().map(|name| by_name(name)).collect()
    }

    fn keep(&self) -> PathBuf {
        let usual = || workspace_root().join("fixtures/fuzz");
        self.keep.clone().unwrap_or_else(usual)
    }

    fn limit(&self) -> Duration {
        Duration::from_secs_f64(self.time_limit.clamp(0.1, 3600.0))
    }

    /// Readers at a time, and processes for each.
    fn shares(&self, n_readers: usize) -> (usize, u64) {
        let cores = || std::thread::available_parallelism().map_or(1, usize::from);
        let jobs = self.jobs.unwrap_or_else(cores).max(1);
        if n_readers >= jobs { (jobs, 1) } else { (n_readers, (jobs / n_readers) as u64) }
    }
}

/// Folder of the workspace: two above the running package's, or the current folder where the
/// program was not started by cargo.
fn workspace_root() -> PathBuf {
    let package = std::env::var_os("CARGO_MANIFEST_DIR").map(PathBuf::from);
    let root = package.as_deref().and_then(|folder| folder.ancestors().nth(2));
    root.unwrap_or(Path::new(".")).to_path_buf()
}

/// Fuzzes, replays or lists.
///
/// # Errors
/// When a reader failed on an input.
pub fn run(args: &Args) -> Result<()> {
    if args.list {
        READERS.iter().for_each(|reader| println!("{}", reader.name()));
        return Ok(());
    }
    ensure!(checks_overflow(), "built without checks of overflow; run as `cargo xtask fuzz`");
    let run = Run { args, readers: args.chosen()?, keep: args.keep(), scratch: Scratch::new()? };
    match (args.replay, args.case) {
        (true, _) => run.replay(),
        (false, Some(case)) => run.one(case),
        (false, None) => run.fuzz(),
    }
}

/// Whether this program was built so that sums of integers are checked, as its libraries are.
fn checks_overflow() -> bool {
    let hook = take_hook();
    set_hook(Box::new(|_| {}));
    let is_checked = catch_unwind(|| black_box(u8::MAX) + black_box(1)).is_err();
    set_hook(hook);
    is_checked
}

/// A run of the task.
struct Run<'a> {
    args: &'a Args,
    readers: Vec<&'static dyn Reader>,
    keep: PathBuf,
    scratch: Scratch,
}

impl Run<'_> {
    /// A worker with a folder.
    fn command(&self, dir: &Path, arguments: &[String]) -> Command {
        let program = std::env::current_exe().unwrap_or_else(|_| "fuzzing".into());
        let mut command = Command::new(program);
        // What a thread pool takes is not the reader's.
        command.arg("fuzz-worker").arg(dir).args(arguments);
        command.env("RAYON_NUM_THREADS", "1").env("RUST_BACKTRACE", "0");
        command
    }

    fn fuzz(&self) -> Result<()> {
        let (n_readers, stride) = self.args.shares(self.readers.len());
        let outcomes: Vec<_> =
            self.readers.iter().map(|_| Mutex::new(Outcome::default())).collect();
        let next = AtomicUsize::new(0);
        println!("{}", table::HEADER);
        let work = || -> Result<()> {
            loop {
                let index = next.fetch_add(1, Ordering::Relaxed);
                let Some(reader) = self.readers.get(index) else { return Ok(()) };
                let outcome = self.fuzz_reader(*reader, stride)?;
                println!("{}", table::row(reader.name(), &outcome));
                *outcomes[index].lock().expect("no thread panics with it") = outcome;
            }
        };
        std::thread::scope(|scope| {
            let threads: Vec<_> = (0..n_readers).map(|_| scope.spawn(work)).collect();
            threads.into_iter().try_for_each(|thread| thread.join().expect("it does not panic"))
        })?;
        let outcomes = outcomes.into_iter().map(|outcome| outcome.into_inner());
        let outcomes: Vec<_> = outcomes.map(|outcome| outcome.expect("no thread panics")).collect();
        println!("{}", table::total(&outcomes));
        self.tell(&outcomes)
    }

    fn fuzz_reader(&self, reader: &'static dyn Reader, stride: u64) -> Result<Outcome> {
        let usual = if self.args.cases.is_some() { f64::from(u32::MAX) } else { 10.0 };
        let seconds = self.args.seconds.unwrap_or(usual);
        let from = self.args.first_case;
        let end = self.args.cases.map_or(u64::MAX, |cases| from.saturating_add(cases));
        let part = |first: u64| {
            let dir = self.scratch.folder(&format!("{}-{first}", reader.name()));
            let seed = self.args.seed;
            let order = Order { seed, first: from + first, stride, end, seconds };
            let start = |arguments: &[String]| self.command(&dir, arguments);
            run_order(reader.name(), &order, &dir, self.args.limit(), &start)
        };
        let parts = std::thread::scope(|scope| {
            let threads: Vec<_> =
                (0..stride).map(|first| scope.spawn(move || part(first))).collect();
            let parts = threads.into_iter().map(|thread| thread.join().expect("it does not panic"));
            parts.collect::<Result<Vec<_>>>()
        })?;
        let mut outcome = Outcome::default();
        parts.into_iter().for_each(|part| outcome.add(part));
        outcome.faults.sort();
        Ok(outcome)
    }

    /// Makes failures small, keeps them, and says how to see them again.
    fn tell(&self, outcomes: &[Outcome]) -> Result<()> {
        let mut n_faults = 0;
        for (reader, outcome) in self.readers.iter().zip(outcomes) {
            for (case, fault) in &outcome.faults {
                let (name, seed) = (reader.name(), self.args.seed);
                println!("{name}: {}: {}", fault.kind, fault.place);
                println!("  again: cargo xtask fuzz --reader {name} --seed {seed} --case {case}");
                let Some(small) = self.smallest(*reader, *case, fault)? else {
                    println!("  not seen again: the machine was busy");
                    continue;
                };
                n_faults += 1;
                match keep::keep(&self.keep.join(name), &small)? {
                    Some(path) => println!("  kept: {} ({} bytes)", path.display(), small.len()),
                    None => println!("  not kept: {} bytes", small.len()),
                }
            }
        }
        ensure!(n_faults == 0, "{n_faults} failures; mend the readers and commit what was kept");
        Ok(())
    }

    /// The shortest input that fails alike; none for a hang that was none.
    fn smallest(&self, reader: &dyn Reader, case: u64, fault: &Fault) -> Result<Option<Vec<u8>>> {
        let input = self.input(reader, case)?;
        let dir = self.scratch.folder("smallest");
        let start = |arguments: &[String]| self.command(&dir, arguments);
        let run = |input: &[u8], limit: Duration| -> Result<bool> {
            let found = run_input(reader.name(), input, &dir, limit, &start)?;
            Ok(found.is_some_and(|found| found.is_like(fault)))
        };
        if fault.kind == Kind::Hang && !run(&input, self.args.limit())? {
            return Ok(None);
        }
        let short = self.args.limit().min(Duration::from_secs_f64(SHORT_TIME_LIMIT));
        let mut fails = |input: &[u8]| run(input, short);
        let is_seen = fails(&input)?;
        Ok(Some(if is_seen { minimize::minimize(&input, &mut fails)? } else { input }))
    }

    fn input(&self, reader: &dyn Reader, case: u64) -> Result<Vec<u8>> {
        let dir = self.scratch.folder("corpus");
        // A corpus is made in an empty folder.
        let _ = fs::remove_dir_all(&dir);
        let corpus = worker::corpus(reader, &dir)?;
        Ok(mutate::case(reader.name(), self.args.seed, case, &corpus, reader.tokens()))
    }

    fn one(&self, case: u64) -> Result<()> {
        for reader in &self.readers {
            let input = self.input(*reader, case)?;
            let name = reader.name();
            println!("{name}: {} bytes: {}", input.len(), String::from_utf8_lossy(&input));
            self.expect_none(*reader, &input, &format!("case {case}"))?;
            println!("{name}: case {case} is read or refused");
        }
        Ok(())
    }

    fn replay(&self) -> Result<()> {
        let mut n_inputs = 0;
        for reader in &self.readers {
            for file in keep::inputs(&self.keep.join(reader.name()))? {
                let input = fs::read(&file)?;
                self.expect_none(*reader, &input, &file.display().to_string())?;
                n_inputs += 1;
            }
        }
        println!("{n_inputs} kept inputs are read or refused");
        Ok(())
    }

    fn expect_none(&self, reader: &dyn Reader, input: &[u8], what: &str) -> Result<()> {
        let name = reader.name();
        let dir = self.scratch.folder(name);
        let start = |arguments: &[String]| self.command(&dir, arguments);
        let fault = run_input(name, input, &dir, self.args.limit(), &start)
            .with_context(|| format!("{name}: {what}"))?;
        match fault {
            None => Ok(()),
            Some(Fault { kind, place }) => anyhow::bail!("{name}: {what}: {kind}: {place}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use crate::case::judge;
    use crate::reader::Verdict;
    use crate::readers::{READERS, by_name};

    #[test]
    fn readers_have_names_of_their_own_and_accept_what_they_start_from() {
        let names: BTreeSet<_> = READERS.iter().map(|reader| reader.name()).collect();
        assert_eq!(names.len(), READERS.len());
        for reader in READERS {
            let dir = tempfile::tempdir().unwrap();
            let (made, files) = (dir.path().join("made"), dir.path().join("files"));
            std::fs::create_dir_all(&made).unwrap();
            std::fs::create_dir_all(&files).unwrap();
            let corpus = reader.corpus(&made).unwrap();
            assert!(!corpus.is_empty(), "{}", reader.name());
            for (number, input) in corpus.iter().enumerate() {
                let verdict = judge(*reader, &files, input);
                assert_eq!(verdict, Ok(Verdict::Accepted), "{} {number}", reader.name());
                assert!(input.len() < 1 << 15, "{} {number}: {}", reader.name(), input.len());
            }
        }
    }

    #[test]
    fn an_unknown_reader_lists_those_there_are() {
        let message = by_name("xlsx").err().unwrap().to_string();
        assert!(message.contains("mcap"), "{message}");
    }
}
