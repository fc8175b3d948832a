//! Where each process gives out: time, memory and error over the number of rows, beside other libraries.

mod data;
mod methods;

use std::fs;
use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use fixtures::workspace_root;
use serde::{Deserialize, Serialize};

use self::data::{Task, pushes, surface_task};
pub(crate) use self::methods::once;
use super::report::{duration, read};

/// What is measured.
#[derive(clap::Args)]
pub(crate) struct Over {
    /// Numbers of rows
    #[arg(
        long,
        value_delimiter = ',',
        value_name = "N",
        default_value = "100,1000,10000,100000,1000000"
    )]
    rows: Vec<usize>,
    /// A folder with table.csv of measured pushes and runs.csv, on which to measure as well
    #[arg(long, value_name = "FOLDER")]
    measured: Option<PathBuf>,
    /// How long a method may take for one number of rows, in s
    #[arg(long, value_name = "S", default_value_t = 300)]
    budget: u64,
    /// Our own methods alone
    #[arg(long)]
    ours: bool,
}

/// One method on one task.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Limit {
    pub(crate) task: String,
    /// Training rows.
    pub(crate) size: usize,
    /// As it calls itself, or as it was asked for where it was stopped.
    pub(crate) method: String,
    /// As it was asked for.
    #[serde(default)]
    pub(crate) asked: String,
    /// How long it might take, in s.
    pub(crate) budget_seconds: u64,
    /// To learn, in s; none if it was stopped after that.
    pub(crate) learn_seconds: Option<f64>,
    /// To predict the test rows with variance, in s.
    pub(crate) predict_seconds: Option<f64>,
    /// Of a process that did it alone.
    pub(crate) peak_memory_mb: Option<f64>,
    /// Mean negative log density of the test rows, in nats.
    pub(crate) nlpd: Option<f64>,
    /// Root mean squared error: of the surface without noise, and of pushes as measured.
    pub(crate) rmse: Option<f64>,
}

/// What a process of its own prints.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Outcome {
    pub(crate) method: String,
    pub(crate) learn_seconds: f64,
    pub(crate) predict_seconds: f64,
    pub(crate) peak_memory_mb: f64,
    pub(crate) nlpd: f64,
    pub(crate) rmse: f64,
}

/// A method, the most rows that it is asked for, and who it is.
struct Method {
    name: &'static str,
    most_rows: usize,
    is_ours: bool,
}

const fn ours(name: &'static str, most_rows: usize) -> Method {
    Method { name, most_rows, is_ours: true }
}

const fn theirs(name: &'static str, most_rows: usize) -> Method {
    Method { name, most_rows, is_ours: false }
}

const METHODS: &[Method] = &[
    ours("exact", 2000),
    ours("sparse", 100_000),
    ours("features", 100_000),
    ours("grid", usize::MAX),
    theirs("gpytorch-exact", 2000),
    theirs("gpytorch-kiss", usize::MAX),
    theirs("gpytorch-svgp", usize::MAX),
    theirs("gpflow-sgpr", 100_000),
];

/// Runs every method on every task and size, prints a table and writes `limits.json`, which keeps
/// what earlier runs measured of other sizes and methods.
///
/// # Errors
/// When files cannot be written or read, or a method of ours fails.
pub(super) fn run(folder: &Path, over: &Over, python: &str) -> Result<()> {
    fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))?;
    let mut tasks: Vec<Task> = over.rows.iter().map(|n| surface_task(*n)).collect();
    if let Some(measured) = &over.measured {
        tasks.extend(pushes(measured)?);
    }
    let path = folder.join("limits.json");
    let mut limits: Vec<Limit> = read(folder, "limits")?.unwrap_or_default();
    for task in &tasks {
        let file = folder.join("limits.bin");
        task.write(&file)?;
        let asked = |method: &&Method| {
            method.most_rows >= task.n_training && (method.is_ours || !over.ours)
        };
        for method in METHODS.iter().filter(asked) {
            let limit = measure(method, task, &file, over.budget, python)?;
            if let Some(limit) = limit {
                print!("{}", line(&limit));
                keep(&mut limits, limit);
                let json = serde_json::to_string_pretty(&limits);
                output::write(&path, json.context("cannot write the rows as JSON")? + "\n")?;
            }
        }
        fs::remove_file(&file).with_context(|| format!("cannot remove {}", file.display()))?;
    }
    Ok(())
}

/// In place of what an earlier run measured of the same, in the order of tasks and sizes.
fn keep(limits: &mut Vec<Limit>, limit: Limit) {
    let key = |one: &Limit| (one.task.clone(), one.size, one.asked.clone());
    limits.retain(|one| key(one) != key(&limit));
    limits.push(limit);
    limits.sort_by(|a, b| (&b.task, a.size).cmp(&(&a.task, b.size)));
}

/// One method in a process of its own; nothing where a library is not there, which is said.
fn measure(
    method: &Method,
    task: &Task,
    file: &Path,
    budget: u64,
    python: &str,
) -> Result<Option<Limit>> {
    let mut command = if method.is_ours {
        let mut command = Command::new(std::env::current_exe()?);
        command.args(["bench", "--limit-once", method.name]);
        command
    } else {
        let mut command = Command::new(python);
        command.arg(workspace_root().join("crates/benchmarks/peers/limits.py")).arg(method.name);
        command
    };
    command.arg(file);
    let begun = Limit {
        task: task.name.clone(),
        size: task.n_training,
        method: method.name.to_owned(),
        asked: method.name.to_owned(),
        budget_seconds: budget,
        learn_seconds: None,
        predict_seconds: None,
        peak_memory_mb: None,
        nlpd: None,
        rmse: None,
    };
    match within(command, Duration::from_secs(budget))? {
        Some(Ok(text)) => {
            let outcome: Outcome =
                serde_json::from_str(&text).with_context(|| format!("bad answer `{text}`"))?;
            Ok(Some(Limit {
                method: outcome.method,
                learn_seconds: Some(outcome.learn_seconds),
                predict_seconds: Some(outcome.predict_seconds),
                peak_memory_mb: Some(outcome.peak_memory_mb),
                nlpd: Some(outcome.nlpd),
                rmse: Some(outcome.rmse),
                ..begun
            }))
        }
        Some(Err(problem)) if method.is_ours => anyhow::bail!("{}: {problem}", method.name),
        Some(Err(problem)) => {
            println!("no {} of {} rows: {problem}", method.name, task.n_training);
            Ok(None)
        }
        None => Ok(Some(begun)),
    }
}

/// What a program prints last, or complains of last; nothing if it takes too long.
fn within(mut program: Command, budget: Duration) -> Result<Option<Result<String, String>>> {
    for library in ["RAYON", "OMP", "OPENBLAS", "MKL", "TF"] {
        program.env(format!("{library}_NUM_THREADS"), "1");
    }
    program.stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = program.spawn().with_context(|| format!("cannot run {program:?}"))?;
    let mut pipes =
        (child.stdout.take().context("no output")?, child.stderr.take().context("none")?);
    let text = thread::spawn(move || {
        let (mut said, mut complained) = (String::new(), String::new());
        let complaints =
            thread::spawn(move || pipes.1.read_to_string(&mut complained).map(|_| complained));
        // What is no text is no answer.
        let _ = pipes.0.read_to_string(&mut said);
        (said, complaints.join().ok().and_then(Result::ok).unwrap_or_default())
    });
    let start = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().context("cannot wait for a program")? {
            break status;
        }
        if start.elapsed() > budget {
            child.kill().context("cannot stop a program")?;
            child.wait().context("cannot wait for a program")?;
            return Ok(None);
        }
        thread::sleep(Duration::from_millis(20));
    };
    let (said, complained) = text.join().map_err(|_| anyhow::anyhow!("a reader failed"))?;
    let last = |text: &str| text.trim_end().lines().last().unwrap_or("it says nothing").to_owned();
    Ok(Some(if status.success() { Ok(last(&said)) } else { Err(last(&complained)) }))
}

impl Limit {
    /// Learning, predicting, memory, log density and error, as people read them.
    pub(super) fn cells(&self) -> [String; 5] {
        let number = |value: Option<f64>, digits: usize| {
            value.map_or("–".to_owned(), |value| format!("{value:.digits$}").replace('-', "−"))
        };
        let learn = self.learn_seconds;
        [
            learn.map_or(format!("> {} s", self.budget_seconds), duration),
            self.predict_seconds.map_or("–".to_owned(), duration),
            self.peak_memory_mb.map_or("–".to_owned(), |mb| format!("{mb:.0} MB")),
            number(self.nlpd, 3),
            number(self.rmse, 5),
        ]
    }
}

fn line(limit: &Limit) -> String {
    let [learn, predict, memory, nlpd, error] = limit.cells();
    format!(
        "{:8} {:>8} {:34} learn {learn:>10} predict {predict:>10} {memory:>9} NLPD {nlpd:>7} error {error}\n",
        limit.task, limit.size, limit.method
    )
}

#[cfg(test)]
mod tests {
    use std::process::Command;
    use std::time::Duration;

    use super::{Limit, keep, within};

    fn shell(script: &str) -> Command {
        let mut program = Command::new("sh");
        program.args(["-c", script]);
        program
    }

    #[test]
    fn a_later_run_takes_the_place_of_the_same_and_no_more() {
        let limit = |size: usize, asked: &str, seconds: f64| Limit {
            task: "surface".into(),
            size,
            method: format!("{asked} of today"),
            asked: asked.into(),
            budget_seconds: 300,
            learn_seconds: Some(seconds),
            predict_seconds: None,
            peak_memory_mb: None,
            nlpd: None,
            rmse: None,
        };
        let mut limits = vec![limit(100, "a", 1.0), limit(1000, "a", 2.0)];
        keep(&mut limits, limit(100, "b", 3.0));
        keep(&mut limits, limit(100, "a", 4.0));
        let seconds: Vec<_> = limits.iter().filter_map(|one| one.learn_seconds).collect();
        assert_eq!(seconds, [3.0, 4.0, 2.0]);
    }

    #[test]
    fn programs_answer_complain_or_are_stopped() {
        let long = Duration::from_secs(20);
        assert_eq!(within(shell("echo a; echo b"), long).unwrap(), Some(Ok("b".to_owned())));
        let failed = within(shell("echo no >&2; exit 3"), long).unwrap();
        assert_eq!(failed, Some(Err("no".to_owned())));
        assert_eq!(within(shell("exec sleep 60"), Duration::from_millis(50)).unwrap(), None);
    }
}
