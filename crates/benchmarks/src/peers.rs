//! Our Gaussian processes beside other libraries', on the same file, one thread each.

use std::fmt::Write as _;
use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail, ensure};
use faer::Mat;
use gp_core::scores::nlpd;
use gp_core::{Gp, LearnOptions, Posterior, SquaredExponential};
use gp_sparse::{Placement, PseudoInputs, SparseGp, SparseOptions};
use rayon::ThreadPoolBuilder;
use serde::{Deserialize, Serialize};

use super::timing::median;
use fixtures::surface::{NOISE_SD, surface};
use fixtures::workspace_root;

/// Sizes and runs of the likelihood.
const LIKELIHOODS: [(usize, usize); 3] = [(500, 21), (2000, 5), (5000, 1)];
const FIT_ROWS: usize = 2000;
const N_TEST: usize = 2000;
const SEED: u64 = 7;

/// Writes the data, times everybody on them, and prints one table.
///
/// # Errors
/// When a file cannot be written, the Rust peers cannot be built, or a process of ours fails.
pub(super) fn run(folder: &Path, python: &str) -> Result<()> {
    fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))?;
    let pool = ThreadPoolBuilder::new().num_threads(1).build().context("cannot start a thread")?;
    let mut rows = Vec::new();
    for (n, runs) in LIKELIHOODS {
        let data = Data::new(n);
        let path = data.write(folder)?;
        rows.push(pool.install(|| data.likelihood(runs))?);
        for library in ["lapack", "sklearn", "gpy"] {
            rows.extend(python_peer(python, &path, library, "likelihood"));
        }
        if n == FIT_ROWS {
            rows.extend(pool.install(|| data.fits())?);
            rows.extend(rust_peers(&path)?);
            for (library, task) in
                [("lapack", "fit"), ("sklearn", "fit"), ("gpy", "fit"), ("gpy", "sparse")]
            {
                rows.extend(python_peer(python, &path, library, task));
            }
        }
    }
    let seconds = |row: &Measured| row.seconds.unwrap_or(f64::INFINITY);
    rows.sort_by(|a, b| {
        (&a.task, a.size).cmp(&(&b.task, b.size)).then(seconds(a).total_cmp(&seconds(b)))
    });
    print!("{}", table(&rows));
    let path = folder.join("gp-peers.json");
    let json = serde_json::to_string_pretty(&rows).context("cannot write the rows as JSON")?;
    Ok(output::write(&path, json + "\n")?)
}

/// What one library took for one task.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Measured {
    /// Its name and version.
    pub(crate) peer: String,
    pub(crate) task: String,
    /// Training rows.
    pub(crate) size: usize,
    /// Median time, in s; none while it runs, and if it was stopped after [`BUDGET`].
    pub(crate) seconds: Option<f64>,
    /// Mean negative log density of the test rows, in nats; none where nothing is predicted.
    pub(crate) nlpd: Option<f64>,
}

impl Measured {
    fn ours(name: &str, task: &str, size: usize, seconds: f64, nlpd: Option<f64>) -> Self {
        let peer = format!("{name} {} (ours)", env!("CARGO_PKG_VERSION"));
        Self { peer, task: task.to_owned(), size, seconds: Some(seconds), nlpd }
    }
}

/// The surface, training rows first.
struct Data {
    x: Mat<f64>,
    y: Vec<f64>,
    n: usize,
}

impl Data {
    fn new(n: usize) -> Self {
        let (x, y) = surface(n + N_TEST, SEED);
        Self { x, y, n }
    }

    fn write(&self, folder: &Path) -> Result<PathBuf> {
        let mut text = String::from("x0,x1,y,split\n");
        for (i, y) in self.y.iter().enumerate() {
            let split = u8::from(i >= self.n);
            writeln!(text, "{},{},{y},{split}", self.x[(i, 0)], self.x[(i, 1)])?;
        }
        let path = folder.join(format!("surface-{}.csv", self.n));
        output::write(&path, text)?;
        Ok(path)
    }

    fn likelihood(&self, runs: usize) -> Result<Measured> {
        let kernel = SquaredExponential::new(&[0.5, 0.7], 0.07)?;
        let x = self.x.subrows(0, self.n);
        let gp = Gp::builder(kernel)
            .noise_variance(NOISE_SD * NOISE_SD)
            .condition(x, &self.y[..self.n])?;
        let mut evaluator = gp.evaluator()?;
        evaluator.evaluate()?;
        let (seconds, _) = timed(runs, || Ok(evaluator.evaluate()?))?;
        Ok(Measured::ours("gp-core", "likelihood with gradient", self.n, seconds, None))
    }

    fn fits(&self) -> Result<Vec<Measured>> {
        let (x, y) = (self.x.subrows(0, self.n), &self.y[..self.n]);
        let options = LearnOptions { n_starts: 1, ..LearnOptions::default() };
        let fit =
            || Ok(Gp::builder(SquaredExponential::unit(2)?).options(options.clone()).fit(x, y)?);
        let (seconds, gp) = timed(1, fit)?;
        let density = self.density(&gp)?;
        let mut rows = vec![Measured::ours("gp-core", "full fit", self.n, seconds, Some(density))];
        for count in [20, 50] {
            let pseudo_inputs = PseudoInputs::Learnt { count, placement: Placement::default() };
            let options = SparseOptions { pseudo_inputs, ..SparseOptions::default() };
            let fit = || Ok(SparseGp::learn(SquaredExponential::unit(2)?, x, y, &options)?.0);
            let (seconds, gp) = timed(5, fit)?;
            let (task, density) = (format!("sparse fit, M = {count}"), self.density(&gp)?);
            rows.push(Measured::ours("gp-sparse", &task, self.n, seconds, Some(density)));
        }
        Ok(rows)
    }

    fn density(&self, posterior: &dyn Posterior) -> Result<f64> {
        let x = self.x.subrows(self.n, N_TEST);
        let (mean, variance) = posterior.predict_observation(x)?;
        Ok(nlpd(&self.y[self.n..], &mean, &variance)?)
    }
}

/// The median time of some runs in s, and what the last one made.
fn timed<T>(runs: usize, mut run: impl FnMut() -> Result<T>) -> Result<(f64, T)> {
    let mut time = || -> Result<(f64, T)> {
        let start = Instant::now();
        let made = run()?;
        Ok((start.elapsed().as_secs_f64(), made))
    };
    let (mut times, mut last) = (Vec::new(), time()?);
    for _ in 1..runs {
        times.push(last.0);
        last = time()?;
    }
    times.push(last.0);
    Ok((median(times), last.1))
}

/// The crate of the peers is built here, and nowhere else.
fn rust_peers(path: &Path) -> Result<Vec<Measured>> {
    let folder = workspace_root().join("crates/benchmarks/peers");
    let mut cargo = Command::new("cargo");
    cargo.args(["build", "--quiet", "--manifest-path"]).arg(folder.join("Cargo.toml"));
    cargo.arg("--target-dir").arg(folder.join("target"));
    let status = cargo.status().context("cannot run cargo")?;
    ensure!(status.success(), "the Rust peers cannot be built");
    let mut rows = Vec::new();
    for task in ["egobox-sparse", "egobox", "friedrich"] {
        let mut peers = Command::new(folder.join("target/debug/peers"));
        peers.arg(path).arg(task);
        match answer(peers, BUDGET)? {
            Ok(found) => rows.extend(found),
            Err(problem) => bail!("the Rust peer {task} failed: {problem}"),
        }
    }
    Ok(rows)
}

/// Nothing where Python or the library is not there, which is said.
fn python_peer(python: &str, path: &Path, library: &str, task: &str) -> Vec<Measured> {
    let mut python = Command::new(python);
    python
        .arg(workspace_root().join("crates/benchmarks/peers/peers.py"))
        .arg(path)
        .args([library, task]);
    let problem = match answer(python, BUDGET) {
        Ok(Ok(rows)) => return rows,
        Ok(Err(problem)) => problem,
        Err(error) => format!("{error:#}"),
    };
    println!("no {task} of {library}: {problem}");
    Vec::new()
}

/// How long a peer may take for one row.
pub(crate) const BUDGET: Duration = Duration::from_mins(2);

/// The rows that a program prints, or the last line of what it complains of.
///
/// Each row comes twice, first without a time when it begins; a program that takes longer than the
/// budget for one is stopped, and that row stays without a time.
fn answer(mut program: Command, budget: Duration) -> Result<Result<Vec<Measured>, String>> {
    for library in ["RAYON", "OMP", "OPENBLAS", "MKL"] {
        program.env(format!("{library}_NUM_THREADS"), "1");
    }
    program.stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = program.spawn().with_context(|| format!("cannot run {program:?}"))?;
    let lines = lines_of(child.stdout.take().context("no output")?);
    let complaints = lines_of(child.stderr.take().context("no error output")?);
    let (mut rows, mut begun) = (Vec::new(), None);
    loop {
        match lines.recv_timeout(budget) {
            Ok(line) => {
                let row: Measured =
                    serde_json::from_str(&line).with_context(|| format!("bad row `{line}`"))?;
                match row.seconds {
                    Some(_) => {
                        begun = None;
                        rows.push(row);
                    }
                    None => begun = Some(row),
                }
            }
            Err(RecvTimeoutError::Timeout) => {
                child.kill().context("cannot stop a peer")?;
                child.wait().context("cannot wait for a peer")?;
                rows.extend(begun);
                return Ok(Ok(rows));
            }
            Err(RecvTimeoutError::Disconnected) => break,
        }
    }
    let status = child.wait().context("cannot wait for a peer")?;
    let last = || complaints.iter().last().unwrap_or_else(|| "it says nothing".to_owned());
    Ok(if status.success() { Ok(rows) } else { Err(last()) })
}

/// What is printed, line by line, read by a thread of its own so that nobody waits for a full pipe.
fn lines_of(output: impl Read + Send + 'static) -> Receiver<String> {
    let (sender, lines) = channel();
    thread::spawn(move || {
        for line in BufReader::new(output).lines().map_while(Result::ok) {
            if sender.send(line).is_err() {
                break;
            }
        }
    });
    lines
}

fn table(rows: &[Measured]) -> String {
    let width = |text: fn(&Measured) -> &str| {
        rows.iter().map(|row| text(row).chars().count()).max().unwrap_or(0).max(4)
    };
    let (tasks, peers) = (width(|row| &row.task), width(|row| &row.peer));
    let mut text =
        format!("{:tasks$} {:>6} {:peers$} {:>10} {:>7}\n", "task", "size", "by", "time", "NLPD");
    for Measured { peer, task, size, seconds, nlpd } in rows {
        let nlpd = nlpd.map_or(String::new(), |nlpd| format!(" {nlpd:>7.3}"));
        let time = match seconds {
            Some(seconds) => format!("{seconds:.4} s"),
            None => format!("> {} s", BUDGET.as_secs()),
        };
        writeln!(text, "{task:tasks$} {size:>6} {peer:peers$} {time:>10}{nlpd}")
            .expect("a String takes any text");
    }
    text
}

#[cfg(test)]
mod tests {
    use std::process::Command;
    use std::time::Duration;

    use super::{BUDGET, Data, Measured, answer, table};

    const BEGUN: &str =
        r#"{"peer": "a 1.0", "task": "fit", "size": 3, "seconds": null, "nlpd": null}"#;
    const DONE: &str =
        r#"{"peer": "a 1.0", "task": "fit", "size": 3, "seconds": 0.5, "nlpd": -2.0}"#;

    #[test]
    fn rows_are_read_and_told() {
        let mut program = Command::new("printf");
        program.args(["%s\n%s\n", BEGUN, DONE]);
        let rows = answer(program, BUDGET).unwrap().unwrap();
        let expected = Measured {
            peer: "a 1.0".into(),
            task: "fit".into(),
            size: 3,
            seconds: Some(0.5),
            nlpd: Some(-2.0),
        };
        assert_eq!(rows, [expected]);
        assert!(
            table(&rows).ends_with("fit       3 a 1.0   0.5000 s  -2.000\n"),
            "{}",
            table(&rows)
        );
        assert!(answer(Command::new("false"), BUDGET).unwrap().is_err());
    }

    #[test]
    fn a_peer_that_takes_too_long_is_stopped_and_told() {
        let mut program = Command::new("sh");
        program.args(["-c", "echo \"$0\"; exec sleep 600", BEGUN]);
        let rows = answer(program, Duration::from_millis(200)).unwrap().unwrap();
        assert!(table(&rows).ends_with("fit       3 a 1.0    > 120 s\n"), "{}", table(&rows));
    }

    #[test]
    fn the_file_holds_training_rows_then_test_rows() {
        let folder = tempfile::tempdir().unwrap();
        let path = Data::new(5).write(folder.path()).unwrap();
        let text = std::fs::read_to_string(path).unwrap();
        let splits: String = text.lines().skip(1).map(|line| &line[line.len() - 1..]).collect();
        assert_eq!(splits, format!("00000{}", "1".repeat(2000)));
    }
}
