//! `cargo xtask ci`: every check that a change has to pass, in order of cost.

use std::process::Command;
use std::time::Instant;

use anyhow::{Context, Result};
use cargo_metadata::{MetadataCommand, Package};
use clap::ValueEnum;

use crate::cargo::{cargo, output, run as run_command, workspace_root};
use crate::{fmt, starters, test, tidy};

/// Time for each reader of files, in s.
const FUZZ_SECONDS: &str = "10";

/// Run every check that a change has to pass; stops at the first that fails.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Stages to leave out, for a caller that runs them itself
    #[arg(long, value_enum, value_delimiter = ',')]
    skip: Vec<Stage>,
}

/// Runs the stages in order and prints the time each took.
///
/// # Errors
/// The first stage that fails, by name.
pub(crate) fn run(args: &Args) -> Result<()> {
    for stage in Stage::value_variants().iter().filter(|stage| !args.skip.contains(stage)) {
        println!("== {}", stage.name());
        let start = Instant::now();
        stage.run().with_context(|| format!("stage `{}`", stage.name()))?;
        println!("== {}: {:.1} s", stage.name(), start.elapsed().as_secs_f64());
    }
    Ok(())
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum Stage {
    /// Formatting
    Fmt,
    /// What tidy's rules forbid
    Tidy,
    /// Lints, as errors
    Clippy,
    /// Documentation, its warnings as errors
    Doc,
    /// Licenses and versions of dependencies, where cargo-deny is installed
    Deny,
    /// Each library packs, and builds without the features that others turn on
    Package,
    /// Committed recordings are what the task that makes them writes
    Fixtures,
    /// All tests and doctests
    Test,
    /// Damaged inputs for every reader
    Fuzz,
    /// Recordings with sealed truth, answered by the diagnosis
    Trials,
}

impl Stage {
    fn name(self) -> &'static str {
        match self {
            Stage::Fmt => "fmt",
            Stage::Tidy => "tidy",
            Stage::Clippy => "clippy",
            Stage::Doc => "doc",
            Stage::Deny => "deny",
            Stage::Package => "package",
            Stage::Fixtures => "fixtures",
            Stage::Test => "test",
            Stage::Fuzz => "fuzz",
            Stage::Trials => "trials",
        }
    }

    fn run(self) -> Result<()> {
        match self {
            Stage::Fmt => fmt::run(&fmt::Args { check: true }),
            Stage::Tidy => tidy::run(&tidy::Args::default()),
            Stage::Clippy => run_command(&mut cargo(&[
                "clippy",
                "--workspace",
                "--all-targets",
                "--",
                "-D",
                "warnings",
            ])),
            Stage::Doc => run_command(
                cargo(&["doc", "--workspace", "--no-deps"]).env("RUSTDOCFLAGS", "-D warnings"),
            ),
            Stage::Deny => check_dependencies(),
            Stage::Package => package_libraries(),
            Stage::Fixtures => start("fixtures", &["--check"]),
            Stage::Test => test::run(&test::Args {}),
            Stage::Fuzz => start("fuzz", &["--seconds", FUZZ_SECONDS]),
            Stage::Trials => start("diagnosis-trials", &["--quick"]),
        }
    }
}

fn start(task: &str, arguments: &[&str]) -> Result<()> {
    run_command(&mut starters::command(task, arguments)?)
}

fn check_dependencies() -> Result<()> {
    if output(Command::new("cargo-deny").arg("--version")).is_err() {
        println!("left out: cargo-deny is not installed");
        return Ok(());
    }
    run_command(&mut cargo(&["deny", "check", "licenses", "bans"]))
}

fn package_libraries() -> Result<()> {
    let metadata = MetadataCommand::new().no_deps().current_dir(workspace_root()).exec()?;
    // A package with an empty list of registries is published nowhere.
    let is_kept = |package: &&Package| package.publish.as_ref().is_some_and(Vec::is_empty);
    let (kept, libraries): (Vec<_>, Vec<_>) =
        metadata.workspace_packages().into_iter().partition(is_kept);
    // What packages hold is checked here; built, one by one, they would take many minutes.
    let mut pack = cargo(&["package", "--workspace", "--quiet", "--allow-dirty", "--no-verify"]);
    for package in kept {
        pack.args(["--exclude", package.name.as_str()]);
    }
    run_command(&mut pack)?;
    for package in libraries {
        run_command(&mut cargo(&["check", "--package", package.name.as_str()]))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use clap::ValueEnum;

    use super::Stage;

    #[test]
    fn stages_are_skipped_by_the_names_they_print() {
        for stage in Stage::value_variants() {
            assert_eq!(Stage::from_str(stage.name(), false), Ok(*stage));
        }
    }
}
