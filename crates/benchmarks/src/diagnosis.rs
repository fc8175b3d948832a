//! The diagnosis of sets from a hundred to a hundred thousand pushes.

mod copies;
mod once;

use std::process::Command;

use anyhow::{Context, Result, ensure};

pub(super) use self::once::{once, peak_memory_mb};

use self::once::Once;
use super::benchmark::{Benchmark, Sizes};
use super::timing::{Row, median};

pub(super) const BENCHMARK: Benchmark = Benchmark {
    name: "diagnosis",
    about: "the screen of the whole catalogue and the whole diagnosis, in a process of their own; \
            size counts pushes; the reference is the time allowed for the whole diagnosis",
    rows,
};

/// Largest set that may take no more than the shorter time, and both times, in s.
const ALLOWED: (usize, f64, f64) = (100, 5.0, 120.0);
/// Sets up to this size are diagnosed more than once.
const REPEATED: (usize, usize) = (1000, 3);

fn rows(sizes: &Sizes) -> Result<Vec<Row>> {
    copies::originals()?;
    let mut rows = Vec::new();
    for &n_pushes in &sizes.pushes {
        let n_times = if n_pushes <= REPEATED.0 { REPEATED.1 } else { 1 };
        let found: Vec<Once> =
            (0..n_times).map(|_| in_own_process(n_pushes)).collect::<Result<_>>()?;
        println!("{n_pushes} pushes: {}", found[0].verdict);
        let (up_to, shorter, longer) = ALLOWED;
        let allowed = if n_pushes <= up_to { shorter } else { longer };
        for (name, seconds) in
            [("screen", Once::screen as fn(&Once) -> f64), ("diagnosis", Once::diagnosis)]
        {
            let median_seconds = median(found.iter().map(seconds).collect());
            let peak = found.iter().map(|once| once.peak_memory_mb).fold(0.0, f64::max);
            rows.push(Row {
                name: name.to_owned(),
                size: n_pushes,
                threads: std::thread::available_parallelism()?.get(),
                median_seconds,
                reference_seconds: allowed,
                ratio: median_seconds / allowed,
                peak_memory_mb: Some(peak),
            });
        }
    }
    Ok(rows)
}

/// What a process of its own says of a set, for the peak of its memory is its own, too.
fn in_own_process(n_pushes: usize) -> Result<Once> {
    let mut command = Command::new(std::env::current_exe()?);
    let output = command.args(["bench", "--once", &n_pushes.to_string()]).output()?;
    let said = String::from_utf8_lossy(&output.stderr);
    ensure!(output.status.success(), "{n_pushes} pushes: {said}");
    serde_json::from_slice(&output.stdout).context("what a diagnosis in a process of its own said")
}
