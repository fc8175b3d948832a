//! Starts workers, sees when one hangs or ends, and says which case it was at.

use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, ensure};

use super::case::{Fault, Kind};
use super::worker::{AT, Order, Tally, parse_fault};

/// How often a worker is looked at.
const LOOK: Duration = Duration::from_millis(20);
/// A reader with so many cases that ended its process as another had before is given up.
const MOST_ENDS: usize = 5;

/// Starts a worker with these arguments.
pub(super) type Start<'a> = dyn Fn(&[String]) -> Command + Sync + 'a;

/// What came of a run.
#[derive(Debug, Default)]
pub(super) struct Outcome {
    pub(super) tally: Tally,
    /// Failures with the case that showed them first.
    pub(super) faults: Vec<(u64, Fault)>,
}

impl Outcome {
    pub(super) fn add(&mut self, other: Self) {
        self.tally.add(&other.tally);
        for (case, fault) in other.faults {
            if !self.faults.iter().any(|(_, known)| known.is_like(&fault)) {
                self.faults.push((case, fault));
            }
        }
    }
}

/// Runs the cases of an order, in a new worker after each that ended one.
///
/// # Errors
/// If a worker cannot be started, or ends before its first case.
pub(super) fn run_order(
    reader: &str,
    order: &Order,
    dir: &Path,
    limit: Duration,
    start: &Start<'_>,
) -> Result<Outcome> {
    let mut outcome = Outcome::default();
    let mut order = order.clone();
    let mut n_ends = 0;
    let begin = Instant::now();
    let seconds = order.seconds;
    loop {
        fs::create_dir_all(dir)?;
        let arguments = [
            ("reader", reader.to_owned()),
            ("seed", order.seed.to_string()),
            ("first", order.first.to_string()),
            ("stride", order.stride.to_string()),
            ("end", order.end.to_string()),
            ("seconds", order.seconds.to_string()),
        ];
        let arguments: Vec<_> =
            arguments.into_iter().flat_map(|(name, value)| [format!("--{name}"), value]).collect();
        let ended = watch(start(&arguments), dir, limit)?;
        let at = ended.at;
        outcome.add(Outcome { tally: ended.tally.unwrap_or_default(), faults: ended.faults });
        let Some(fault) = ended.fault else { break };
        let at = at.with_context(|| format!("{reader}: no case was begun: {}", fault.place))?;
        let cases = (at - order.first) / order.stride + 1;
        n_ends += usize::from(outcome.faults.iter().any(|(_, known)| known.is_like(&fault)));
        outcome
            .add(Outcome { tally: Tally { cases, ..Tally::default() }, faults: vec![(at, fault)] });
        order.first = at + order.stride;
        order.seconds = seconds - begin.elapsed().as_secs_f64();
        if n_ends >= MOST_ENDS || order.first >= order.end || order.seconds <= 0.0 {
            break;
        }
    }
    Ok(outcome)
}

/// Reads one input in a process of its own.
///
/// # Errors
/// If it cannot be started.
pub(super) fn run_input(
    reader: &str,
    input: &[u8],
    dir: &Path,
    limit: Duration,
    start: &Start<'_>,
) -> Result<Option<Fault>> {
    fs::create_dir_all(dir)?;
    let file = dir.join("input");
    fs::write(&file, input)?;
    let arguments = ["--reader", reader, "--input", &file.to_string_lossy()].map(str::to_owned);
    let ended = watch(start(&arguments), dir, limit)?;
    if let (Some(fault), None) = (&ended.fault, ended.at) {
        ensure!(fault.kind == Kind::Hang, "{reader}: {}", fault.place);
    }
    Ok(ended.faults.into_iter().next().map(|(_, fault)| fault).or(ended.fault))
}

/// How a worker ended.
struct Ended {
    tally: Option<Tally>,
    faults: Vec<(u64, Fault)>,
    /// If it hung or ended early.
    fault: Option<Fault>,
    at: Option<u64>,
}

/// Waits for a worker, and ends it when it stays at one case for longer than the limit.
fn watch(mut command: Command, dir: &Path, limit: Duration) -> Result<Ended> {
    let at_file = dir.join(AT);
    let _ = fs::remove_file(&at_file);
    let mut child = command
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .context("cannot start a worker")?;
    let out = child.stdout.take().context("a worker without standard output")?;
    let lines = thread::spawn(move || {
        BufReader::new(out).lines().map_while(Result::ok).collect::<Vec<_>>()
    });
    let err = child.stderr.take().context("a worker without standard error")?;
    let errors = thread::spawn(move || {
        let mut text = Vec::new();
        let _ = BufReader::new(err).take(1 << 16).read_to_end(&mut text);
        String::from_utf8_lossy(&text).into_owned()
    });
    let status = wait(&mut child, &at_file, limit)?;
    let lines = lines.join().unwrap_or_default();
    let errors = errors.join().unwrap_or_default();
    let at = case_of(&at_file);
    let tally = lines.iter().rev().find_map(|line| Tally::parse(line));
    let faults = lines.iter().filter_map(|line| parse_fault(line)).collect();
    // The runtime's last words are advice.
    let last = errors.lines().rfind(|line| !line.trim().is_empty() && !line.starts_with("note: "));
    let fault = match status {
        Some(status) if status.success() && tally.is_some() => None,
        Some(status) => {
            let place = format!("{status}: {}", last.unwrap_or("nothing was said"));
            Some(Fault { kind: Kind::Crash, place })
        }
        None => {
            let place = format!("no end after {} s", limit.as_secs_f64());
            Some(Fault { kind: Kind::Hang, place })
        }
    };
    Ok(Ended { tally, faults, fault, at })
}

/// The exit status; none if the worker was ended.
fn wait(child: &mut Child, at_file: &Path, limit: Duration) -> Result<Option<ExitStatus>> {
    let mut last = (None, Instant::now());
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(Some(status));
        }
        let at = case_of(at_file);
        if at != last.0 {
            last = (at, Instant::now());
        }
        // The corpus is made before the first case, which may take longer.
        let patience = if at.is_some() { limit } else { limit + Duration::from_secs(60) };
        if last.1.elapsed() > patience {
            child.kill()?;
            child.wait()?;
            return Ok(None);
        }
        thread::sleep(LOOK);
    }
}

fn case_of(at_file: &Path) -> Option<u64> {
    Some(u64::from_le_bytes(fs::read(at_file).ok()?.try_into().ok()?))
}
