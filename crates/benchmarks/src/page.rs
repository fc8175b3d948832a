//! The page about speed, from what runs left in `target/bench`.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use anyhow::{Result, ensure};
use fixtures::workspace_root;

use super::benchmark::Benchmark;
use super::limits::Limit;
use super::peers::{BUDGET, Measured};
use super::report::{duration, ratio, read};
use super::timing::Row;

/// Writes `docs/performance.md`.
///
/// # Errors
/// When no run has left anything, or a file cannot be read or written.
pub(crate) fn write(folder: &Path, benchmarks: &[Benchmark]) -> Result<()> {
    let rows = |name: &str| read::<Row>(folder, name);
    let mut text = String::from(HEAD);
    let build = if cfg!(debug_assertions) { ", built with checks (no release)" } else { "" };
    writeln!(text, "\nMeasured on {}{build}.\n", machine()).expect("a String takes any text");
    let mut is_empty = true;
    for benchmark in benchmarks {
        if let Some(rows) = rows(benchmark.name)? {
            text += &section(benchmark, &rows);
            is_empty = false;
        }
    }
    if let Some(limits) = read::<Limit>(folder, "limits")? {
        text += &limits_section(&limits);
        is_empty = false;
    }
    if let Some(peers) = read::<Measured>(folder, "gp-peers")? {
        text += &peers_section(&peers);
        is_empty = false;
    }
    ensure!(!is_empty, "no run has left anything in {}; run `cargo xtask bench`", folder.display());
    let path = workspace_root().join("docs/performance.md");
    output::write(&path, text.trim_end().to_owned() + "\n")?;
    println!("written to {}", path.display());
    Ok(())
}

const HEAD: &str = "# Speed

Written by `cargo xtask bench --page` from what the runs named below left in `target/bench`. A ratio is our
median time over that of a reference, both timed in turn in one process: for Gaussian processes the reference
is the machine's floor, `faer`'s matrix product with as many operations as the task has.
";

/// The processor as Linux names it, and how many threads it offers.
fn machine() -> String {
    let text = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name =
        text.lines().find_map(|line| Some(line.strip_prefix("model name")?.split_once(':')?.1));
    let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    format!("{}, {threads} threads", name.unwrap_or("an unknown processor").trim())
}

fn section(benchmark: &Benchmark, rows: &[Row]) -> String {
    let mut text = format!(
        "## {}\n\nOurs: {}. `cargo run --release -p benchmarks -- bench {}`\n\n\
         | task | size | threads | time | reference | ratio |\n|---|---|---|---|---|---|\n",
        benchmark.name, benchmark.about, benchmark.name
    );
    for row in rows {
        let memory = row.peak_memory_mb.map_or(String::new(), |mb| format!(", {mb:.0} MB"));
        writeln!(
            text,
            "| {}{memory} | {} | {} | {} | {} | {} |",
            row.name,
            row.size,
            row.threads,
            duration(row.median_seconds),
            duration(row.reference_seconds),
            ratio(row.ratio)
        )
        .expect("a String takes any text");
    }
    text + "\n"
}

fn limits_section(limits: &[Limit]) -> String {
    let mut text = String::from(
        "## Where each process gives out\n\nOn one thread, each in a process of its own: time to learn all \
         parameters from the usual start, to predict the test rows with variance (2000 of the surface; of \
         pushes the runs of fold 0), the most memory, \
         the mean negative log density of those rows and the root mean squared error (of the surface: from \
         the truth without noise; of pushes: of the turn as measured, in standard deviations). A method \
         that takes longer than its `--budget` is stopped (>). \
         `cargo run --release -p benchmarks -- bench --limits --python PYTHON --measured FOLDER`, or with `--ours` \
         without other libraries\n\n\
         | task | rows | method | learn | predict | memory | NLPD | error |\n|---|---|---|---|---|---|---|---|\n",
    );
    for limit in limits {
        let Limit { task, size, method, .. } = limit;
        writeln!(text, "| {task} | {size} | {method} | {} |", limit.cells().join(" | "))
            .expect("a String takes any text");
    }
    text + "\n"
}

fn peers_section(peers: &[Measured]) -> String {
    let mut text = String::from(
        "## Beside other libraries\n\nThe same file, one thread each; NLPD of 2000 other rows. \
         `cargo run --release -p benchmarks -- bench gp --peers --python PYTHON`\n\n\
         | task | rows | by | time | NLPD |\n|---|---|---|---|---|\n",
    );
    for Measured { peer, task, size, seconds, nlpd } in peers {
        let time = seconds.map_or(format!("> {} s", BUDGET.as_secs()), duration);
        let nlpd = nlpd.map_or(String::new(), |nlpd| format!("{nlpd:.3}").replace('-', "−"));
        writeln!(text, "| {task} | {size} | {peer} | {time} | {nlpd} |")
            .expect("a String takes any text");
    }
    text + "\n"
}

#[cfg(test)]
mod tests {
    use super::{Limit, limits_section};

    #[test]
    fn limits_are_told_with_what_was_stopped() {
        let limit = Limit {
            task: "surface".into(),
            size: 100,
            method: "a".into(),
            asked: "a".into(),
            budget_seconds: 40,
            learn_seconds: Some(1.5),
            predict_seconds: Some(0.002),
            peak_memory_mb: Some(12.4),
            nlpd: Some(-2.25),
            rmse: Some(0.01),
        };
        let none = Limit { predict_seconds: None, peak_memory_mb: None, ..limit.clone() };
        let stopped = Limit { learn_seconds: None, nlpd: None, rmse: None, ..none };
        let text = limits_section(&[limit, stopped]);
        assert!(
            text.contains("| surface | 100 | a | 1.50 s | 2.00 ms | 12 MB | −2.250 | 0.01000 |\n"),
            "{text}"
        );
        assert!(text.contains("| a | > 40 s | – | – | – | – |\n"), "{text}");
    }
}
