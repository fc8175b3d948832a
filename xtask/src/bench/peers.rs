//! Our Gaussian processes beside other libraries', on the same file, one thread each.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use anyhow::{Context, Result, bail};
use faer::Mat;
use gp_core::scores::nlpd;
use gp_core::{Gp, LearnOptions, Posterior, SquaredExponential};
use gp_sparse::{Placement, PseudoInputs, SparseGp, SparseOptions};
use rayon::ThreadPoolBuilder;
use serde::{Deserialize, Serialize};

use super::surface::{NOISE_SD, surface};
use super::timing::median;
use crate::cargo::workspace_root;

/// Sizes and runs of the likelihood.
const LIKELIHOODS: [(usize, usize); 3] = [(500, 21), (2000, 5), (5000, 1)];
const FIT_ROWS: usize = 2000;
const N_TEST: usize = 2000;
const SEED: u64 = 7;

/// Writes the data, times everybody on them, and prints one table.
///
/// # Errors
/// When a file cannot be written, the Rust peers cannot be built, or a process of ours fails.
pub(super) fn run(folder: &Path) -> Result<()> {
    fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))?;
    let pool = ThreadPoolBuilder::new().num_threads(1).build().context("cannot start a thread")?;
    let mut rows = Vec::new();
    for (n, runs) in LIKELIHOODS {
        let data = Data::new(n);
        let path = data.write(folder)?;
        rows.push(pool.install(|| data.likelihood(runs))?);
        rows.extend(python(&path, "likelihood"));
        if n == FIT_ROWS {
            rows.extend(pool.install(|| data.fits())?);
            rows.extend(rust_peers(&path)?);
            rows.extend(python(&path, "fit"));
        }
    }
    rows.sort_by(|a, b| {
        (&a.task, a.size).cmp(&(&b.task, b.size)).then(a.seconds.total_cmp(&b.seconds))
    });
    print!("{}", table(&rows));
    let path = folder.join("gp-peers.json");
    let json = serde_json::to_string_pretty(&rows).context("cannot write the rows as JSON")?;
    fs::write(&path, json + "\n").with_context(|| format!("cannot write {}", path.display()))
}

/// What one library took for one task.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct Measured {
    /// Its name and version.
    peer: String,
    task: String,
    /// Training rows.
    size: usize,
    /// Median time, in s.
    seconds: f64,
    /// Mean negative log density of the test rows, in nats; none where nothing is predicted.
    nlpd: Option<f64>,
}

impl Measured {
    fn ours(name: &str, task: &str, size: usize, seconds: f64, nlpd: Option<f64>) -> Self {
        let peer = format!("{name} {} (ours)", env!("CARGO_PKG_VERSION"));
        Self { peer, task: task.to_owned(), size, seconds, nlpd }
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
        fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))?;
        Ok(path)
    }

    fn likelihood(&self, runs: usize) -> Result<Measured> {
        let kernel = SquaredExponential::new(&[0.5, 0.7], 0.07)?;
        let x = self.x.subrows(0, self.n);
        let gp = Gp::fit(kernel, x, &self.y[..self.n], NOISE_SD * NOISE_SD)?;
        let mut evaluator = gp.evaluator()?;
        evaluator.evaluate()?;
        let (seconds, _) = timed(runs, || Ok(evaluator.evaluate()?))?;
        Ok(Measured::ours("gp-core", "likelihood with gradient", self.n, seconds, None))
    }

    fn fits(&self) -> Result<Vec<Measured>> {
        let (x, y) = (self.x.subrows(0, self.n), &self.y[..self.n]);
        let options = LearnOptions { n_starts: 1, ..LearnOptions::default() };
        let fit = || Ok(Gp::learn(SquaredExponential::unit(2)?, x, y, &options)?.0);
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
    let manifest = workspace_root().join("xtask/peers/Cargo.toml");
    let mut cargo = Command::new("cargo");
    cargo
        .args(["run", "--release", "--quiet", "--manifest-path"])
        .arg(manifest)
        .arg("--")
        .arg(path);
    match answer(cargo)? {
        Ok(rows) => Ok(rows),
        Err(problem) => bail!("the Rust peers failed: {problem}"),
    }
}

/// Nothing where Python or its libraries are not there, which is said.
fn python(path: &Path, task: &str) -> Vec<Measured> {
    let mut python = Command::new("python3");
    python.arg(workspace_root().join("xtask/peers/peers.py")).arg(path).arg(task);
    let problem = match answer(python) {
        Ok(Ok(rows)) => return rows,
        Ok(Err(problem)) => problem,
        Err(error) => format!("{error:#}"),
    };
    println!("no peers of Python: {problem}");
    Vec::new()
}

/// The rows that a program prints, or the last line of what it complains of.
fn answer(mut program: Command) -> Result<Result<Vec<Measured>, String>> {
    for library in ["RAYON", "OMP", "OPENBLAS", "MKL"] {
        program.env(format!("{library}_NUM_THREADS"), "1");
    }
    let output = program.output().with_context(|| format!("cannot run {program:?}"))?;
    if !output.status.success() {
        let text = String::from_utf8_lossy(&output.stderr);
        return Ok(Err(text.lines().last().unwrap_or("it says nothing").to_owned()));
    }
    let text = String::from_utf8(output.stdout).context("a peer prints no UTF-8")?;
    let row = |line: &str| serde_json::from_str(line).with_context(|| format!("bad row `{line}`"));
    Ok(Ok(text.lines().map(row).collect::<Result<_>>()?))
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
        writeln!(text, "{task:tasks$} {size:>6} {peer:peers$} {seconds:>8.4} s{nlpd}")
            .expect("a String takes any text");
    }
    text
}

#[cfg(test)]
mod tests {
    use std::process::Command;

    use super::{Data, Measured, answer, table};

    #[test]
    fn rows_are_read_and_told() {
        let mut program = Command::new("echo");
        program.arg(r#"{"peer": "a 1.0", "task": "fit", "size": 3, "seconds": 0.5, "nlpd": -2.0}"#);
        let rows = answer(program).unwrap().unwrap();
        let expected = Measured {
            peer: "a 1.0".into(),
            task: "fit".into(),
            size: 3,
            seconds: 0.5,
            nlpd: Some(-2.0),
        };
        assert_eq!(rows, [expected]);
        assert!(
            table(&rows).ends_with("fit       3 a 1.0   0.5000 s  -2.000\n"),
            "{}",
            table(&rows)
        );
        assert!(answer(Command::new("false")).unwrap().is_err());
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
