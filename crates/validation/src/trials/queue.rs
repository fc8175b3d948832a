//! Trials run as child processes: a crash or an endless loop takes no other trial with it.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::Mutex;
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, Result};

use super::case::Case;
use super::record::{Record, append};
use super::score::is_right;
use super::truth::{self, Truth};

/// How trials are run.
pub(super) struct Queue<'a> {
    pub(super) folder: &'a Path,
    /// Gets one line a finished trial.
    pub(super) results: &'a Path,
    pub(super) n_jobs: usize,
    pub(super) patience: Duration,
    pub(super) seed: u64,
}

/// How often a child is looked at.
const GLANCE: Duration = Duration::from_millis(50);

/// A trial's own folder.
pub(super) fn folder_of(folder: &Path, case: &Case) -> PathBuf {
    folder.join("work").join(format!("{}-{}", case.name.replace('/', "-"), case.seed))
}

impl Queue<'_> {
    /// Runs trials in their order, several at a time.
    ///
    /// # Errors
    /// A child that cannot be started, results that cannot be written.
    pub(super) fn run(&self, cases: &[Case]) -> Result<()> {
        let next = Mutex::new(cases.iter().enumerate());
        let start = Instant::now();
        let worker = || -> Result<()> {
            loop {
                let taken = next.lock().map_or(None, |mut cases| cases.next());
                let Some((index, case)) = taken else { return Ok(()) };
                let record = self.trial(case)?;
                let _one_at_a_time = next.lock();
                append(self.results, &record)?;
                let mark = if is_right(&record) { "    " } else { "miss" };
                let (time, n) = (start.elapsed().as_secs(), cases.len());
                let line = format!(
                    "{mark} {}/{n} {time:5} s  {}: {} ({:.1} s)",
                    index + 1,
                    case.name,
                    record.outcome.text(),
                    record.seconds
                );
                writeln!(std::io::stderr(), "{line}")?;
            }
        };
        thread::scope(|scope| {
            let workers: Vec<_> = (0..self.n_jobs).map(|_| scope.spawn(worker)).collect();
            workers.into_iter().try_for_each(|worker| {
                worker.join().unwrap_or_else(|_| Err(anyhow::anyhow!("a worker panicked")))
            })
        })
    }

    /// The record of one trial, whatever happens to it.
    fn trial(&self, case: &Case) -> Result<Record> {
        let folder = folder_of(self.folder, case);
        let path = folder.with_extension("record.json");
        if folder.exists() {
            fs::remove_dir_all(&folder)?;
        }
        if let Some(parent) = folder.parent() {
            fs::create_dir_all(parent)?;
        }
        let threads = thread::available_parallelism().map_or(1, usize::from).div_ceil(self.n_jobs);
        let program = std::env::current_exe().context("where is this program?")?;
        let start = Instant::now();
        let mut child = Command::new(program)
            .args(["diagnosis-trials", "--case", &case.name])
            .args(["--seed", &self.seed.to_string()])
            .arg("--record")
            .arg(&path)
            .env("RAYON_NUM_THREADS", threads.to_string())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .context("cannot start a trial")?;
        let status = wait(&mut child, self.patience)?;
        let seconds = start.elapsed().as_secs_f64();
        let told = fs::read_to_string(&path).ok().and_then(|text| serde_json::from_str(&text).ok());
        if let Some(record) = told {
            fs::remove_file(&path)?;
            return Ok(record);
        }
        let why = match status {
            None => format!("no answer within {} s", self.patience.as_secs()),
            Some(status) => format!("{status}: {}", last_line(child)),
        };
        let sealed = folder.join("made/set.truth.toml");
        let (truth, why) = match truth::open(&sealed, &case.setup.profile().nominal()) {
            Ok(truth) => (truth, why),
            Err(error) => (Truth::default(), format!("{why}; its truth is not known: {error:#}")),
        };
        if folder.exists() {
            fs::remove_dir_all(&folder)?;
        }
        Ok(Record::failed(case, why, truth, seconds))
    }
}

/// Waits for a child, and ends it when patience does: then there is no status.
fn wait(child: &mut Child, patience: Duration) -> Result<Option<ExitStatus>> {
    let start = Instant::now();
    while start.elapsed() < patience {
        if let Some(status) = child.try_wait()? {
            return Ok(Some(status));
        }
        thread::sleep(GLANCE);
    }
    child.kill().context("cannot end a trial")?;
    child.wait()?;
    Ok(None)
}

fn last_line(child: Child) -> String {
    let output = child.wait_with_output().map(|output| output.stderr).unwrap_or_default();
    let text = String::from_utf8_lossy(&output);
    text.trim().lines().last().unwrap_or_default().to_owned()
}

#[cfg(test)]
mod tests {
    use std::process::Command;
    use std::time::Duration;

    use super::wait;

    #[test]
    fn a_child_that_takes_too_long_is_ended() {
        let mut slow = Command::new("sleep").arg("60").spawn().unwrap();
        assert_eq!(wait(&mut slow, Duration::from_millis(120)).unwrap(), None);
        let mut quick = Command::new("sh").args(["-c", "exit 3"]).spawn().unwrap();
        let status = wait(&mut quick, Duration::from_secs(20)).unwrap().unwrap();
        assert_eq!(status.code(), Some(3));
    }
}
