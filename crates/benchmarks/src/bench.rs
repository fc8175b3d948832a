//! `cargo xtask bench`: speed beside a reference, as a table and as `target/bench/NAME.json`.
//!
//! One file a benchmark; [`BENCHMARKS`] registers them.

use anyhow::{Context, Result};
use clap::builder::PossibleValuesParser;
use fixtures::workspace_root;

use crate::benchmark::{Benchmark, Sizes};
use crate::report::publish;
use crate::{
    contact, diagnosis, effects, filter, gp, gp_rff, gp_sparse, ingest, limits, matching, page,
    peers, plant, push, stream,
};

/// Time the workspace beside a reference; writes target/bench/NAME.json.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Benchmarks to run, all without it
    #[arg(value_parser = PossibleValuesParser::new(BENCHMARKS.iter().map(|benchmark| benchmark.name)))]
    names: Vec<String>,
    #[command(flatten)]
    sizes: Sizes,
    /// Time other libraries' Gaussian processes beside ours instead, on the same data
    #[arg(long)]
    peers: bool,
    /// Time and score the processes over the number of rows instead, up to a million
    #[arg(long)]
    limits: bool,
    #[command(flatten)]
    over: limits::Over,
    /// Write docs/performance.md from what the runs so far left in target/bench
    #[arg(long)]
    page: bool,
    /// The Python that has the other libraries
    #[arg(long, value_name = "PROGRAM", default_value = "python3")]
    python: String,
    /// Learn and predict once with one method on a file of `--limits`, and print it as JSON
    #[arg(long, hide = true, num_args = 2, value_names = ["METHOD", "FILE"])]
    limit_once: Vec<String>,
    /// Diagnose so many pushes once and print what it took as JSON
    #[arg(long, hide = true, value_name = "N")]
    once: Option<usize>,
}

/// Runs the benchmarks named, or all of them.
///
/// # Errors
/// The first benchmark that fails, by name.
pub(crate) fn run(args: &Args) -> Result<()> {
    if let Some(n_pushes) = args.once {
        return diagnosis::once(n_pushes);
    }
    if let [method, file] = &args.limit_once[..] {
        return limits::once(method, file.as_ref());
    }
    let folder = workspace_root().join("target/bench");
    if args.page {
        return page::write(&folder, BENCHMARKS);
    }
    if cfg!(debug_assertions) {
        println!("built with checks; without: cargo run --release -p benchmarks -- bench");
    }
    if args.peers {
        return peers::run(&folder, &args.python);
    }
    if args.limits {
        return limits::run(&folder, &args.over, &args.python);
    }
    let is_chosen = |name: &str| args.names.is_empty() || args.names.iter().any(|n| n == name);
    for benchmark in BENCHMARKS.iter().filter(|benchmark| is_chosen(benchmark.name)) {
        println!("{}: {}", benchmark.name, benchmark.about);
        (benchmark.rows)(&args.sizes)
            .and_then(|rows| publish(benchmark.name, &rows, &folder))
            .with_context(|| format!("benchmark `{}`", benchmark.name))?;
    }
    Ok(())
}

const BENCHMARKS: &[Benchmark] = &[
    contact::BENCHMARK,
    diagnosis::BENCHMARK,
    effects::BENCHMARK,
    filter::BENCHMARK,
    gp::BENCHMARK,
    gp_rff::BENCHMARK,
    gp_sparse::BENCHMARK,
    ingest::BENCHMARK,
    matching::BENCHMARK,
    plant::BENCHMARK,
    push::BENCHMARK,
    stream::BENCHMARK,
];

#[cfg(test)]
mod tests {
    use super::BENCHMARKS;

    #[test]
    fn benchmarks_are_registered_once_and_in_order() {
        assert!(BENCHMARKS.is_sorted_by(|a, b| a.name < b.name));
    }
}
