//! `cargo xtask test`: every test and doctest of the workspace, and their closing total.

use std::fmt;
use std::io::{self, BufRead, BufReader, Write};
use std::process::Stdio;

use anyhow::{Context, Result, bail, ensure};

use crate::cargo::cargo;

/// Run every test and doctest of the workspace and print their total.
#[derive(clap::Args)]
pub(crate) struct Args {}

/// Streams the runner's output; the last line on standard output is `N passed, N failed`.
///
/// # Errors
/// When a test fails, when something does not compile, or when nothing ran.
pub(crate) fn run(_args: &Args) -> Result<()> {
    let mut runner = cargo(&["test", "--workspace", "--no-fail-fast"])
        .stdout(Stdio::piped())
        .spawn()
        .context("cannot start cargo test")?;
    let lines = runner.stdout.take().context("cargo test has no standard output")?;
    let total = tally(BufReader::new(lines), io::stdout())?;
    let status = runner.wait().context("cannot wait for cargo test")?;
    println!("{total}");
    judge(&total, status.success())
}

/// Sums of the runner's `test result:` lines.
#[derive(Debug, Default, PartialEq)]
struct Total {
    passed: usize,
    failed: usize,
    ignored: usize,
}

impl Total {
    fn add(&mut self, line: &str) {
        let Some(counts) = line.strip_prefix("test result: ") else { return };
        let words: Vec<_> = counts.split_whitespace().collect();
        for pair in words.windows(2) {
            let Ok(count) = pair[0].parse::<usize>() else { continue };
            match pair[1] {
                "passed;" => self.passed += count,
                "failed;" => self.failed += count,
                "ignored;" => self.ignored += count,
                _ => {}
            }
        }
    }
}

impl fmt::Display for Total {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.ignored > 0 {
            writeln!(formatter, "{} ignored", self.ignored)?;
        }
        write!(formatter, "{} passed, {} failed", self.passed, self.failed)
    }
}

/// Copies every line to `out` as it arrives, and sums the results.
fn tally(mut lines: impl BufRead, mut out: impl Write) -> Result<Total> {
    let mut total = Total::default();
    let mut line = Vec::new();
    while lines.read_until(b'\n', &mut line).context("cannot read the output of cargo test")? > 0 {
        out.write_all(&line).context("cannot write to standard output")?;
        total.add(&String::from_utf8_lossy(&line));
        line.clear();
    }
    Ok(total)
}

fn judge(total: &Total, runner_succeeded: bool) -> Result<()> {
    if total.failed > 0 {
        bail!("{} failed", if total.failed == 1 { "a test" } else { "tests" });
    }
    ensure!(runner_succeeded, "cargo test failed outside the tests: see its messages above");
    ensure!(total.passed > 0, "no test ran");
    Ok(())
}

#[cfg(test)]
mod tests {
    use proptest::test_runner::{Config, RngSeed};

    use super::{Total, judge, tally};

    const OUTPUT: &str = "\nrunning 3 tests\ntest a ... ok\n\
        test result: ok. 3 passed; 0 failed; 1 ignored; 0 measured; 0 filtered out; finished in 0.01s\n\
        \ntest result: FAILED. 4 passed; 2 failed; 0 ignored; 0 measured; 9 filtered out\n\
        a test that prints test result: ok. 50 passed; counts for nothing\n";

    #[test]
    fn the_total_sums_the_result_lines_only() {
        let mut copy = Vec::new();
        let total = tally(OUTPUT.as_bytes(), &mut copy).expect("in memory");
        assert_eq!(total, Total { passed: 7, failed: 2, ignored: 1 });
        assert_eq!(copy, OUTPUT.as_bytes());
    }

    #[test]
    fn the_last_line_states_passed_and_failed() {
        let total = Total { passed: 7, failed: 2, ignored: 1 };
        assert_eq!(total.to_string().lines().last(), Some("7 passed, 2 failed"));
    }

    #[test]
    fn only_a_run_with_passing_tests_and_no_failure_succeeds() {
        let passed = Total { passed: 1, ..Total::default() };
        let failed = Total { passed: 1, failed: 1, ignored: 0 };
        assert!(judge(&passed, true).is_ok());
        assert_eq!(judge(&failed, false).expect_err("failed").to_string(), "a test failed");
        assert!(
            judge(&passed, false)
                .expect_err("compile error")
                .to_string()
                .contains("outside the tests")
        );
        assert_eq!(judge(&Total::default(), true).expect_err("empty").to_string(), "no test ran");
    }

    /// As `.cargo/config.toml` says.
    #[test]
    fn laws_of_random_inputs_meet_the_same_inputs_on_every_run() {
        let config = Config::default();
        assert_eq!(config.rng_seed, RngSeed::Fixed(7));
        assert!(config.failure_persistence.is_none());
    }
}
