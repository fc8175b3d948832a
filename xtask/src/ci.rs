//! `cargo xtask ci`: every check that a change has to pass, in order of cost.

use std::time::Instant;

use anyhow::{Context, Result};
use clap::builder::PossibleValuesParser;
use clap::{Arg, ArgAction, ArgMatches, Command as Task};

use crate::cargo::{cargo, run as run_command};
use crate::packages::packages;
use crate::{dependencies, fmt, starters, test, tidy};

/// Time for each reader of files, in s.
const FUZZ_SECONDS: &str = "5";

/// The task's name, help and options.
pub(crate) fn task() -> Task {
    let skip = Arg::new("skip")
        .long("skip")
        .value_name("STAGE")
        .value_parser(PossibleValuesParser::new(STAGES.map(|stage| stage.name)))
        .value_delimiter(',')
        .action(ArgAction::Append)
        .help("Stages to leave out, for a caller that runs them itself");
    Task::new("ci")
        .about("Run every check that a change has to pass; stops at the first that fails")
        .arg(skip)
}

/// Runs the stages in order and prints the time each took.
///
/// # Errors
/// The first stage that fails, by name.
pub(crate) fn run(matches: &ArgMatches) -> Result<()> {
    let skipped: Vec<&String> = matches.get_many("skip").unwrap_or_default().collect();
    for Stage { name, run } in
        STAGES.iter().filter(|stage| !skipped.iter().any(|skipped| *skipped == stage.name))
    {
        println!("== {name}");
        let start = Instant::now();
        run().with_context(|| format!("stage `{name}`"))?;
        println!("== {name}: {:.1} s", start.elapsed().as_secs_f64());
    }
    Ok(())
}

/// A check, by the name that it prints and is skipped by.
struct Stage {
    name: &'static str,
    run: fn() -> Result<()>,
}

/// In order of cost.
const STAGES: [Stage; 10] = [
    Stage { name: "fmt", run: || fmt::run(true) },
    Stage { name: "tidy", run: tidy::run },
    Stage { name: "clippy", run: clippy },
    Stage { name: "doc", run: doc },
    // Licenses and versions of dependencies.
    Stage { name: "dependencies", run: dependencies::run },
    // Each library packs, and builds without the features that others turn on.
    Stage { name: "package", run: package_libraries },
    // Committed recordings are what the task that makes them writes.
    Stage { name: "fixtures", run: || start("fixtures", &["--check"]) },
    Stage { name: "test", run: test::run },
    Stage { name: "fuzz", run: || start("fuzz", &["--seconds", FUZZ_SECONDS]) },
    // Recordings with sealed truth, answered by the diagnosis.
    Stage { name: "trials", run: || start("diagnosis-trials", &["--quick"]) },
];

fn clippy() -> Result<()> {
    run_command(&mut cargo(&["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"]))
}

fn doc() -> Result<()> {
    let mut doc = cargo(&["doc", "--workspace", "--no-deps"]);
    run_command(doc.env("RUSTDOCFLAGS", "-D warnings"))
}

fn start(task: &str, arguments: &[&str]) -> Result<()> {
    run_command(&mut starters::command(task, arguments)?)
}

fn package_libraries() -> Result<()> {
    let packages = packages()?;
    let (published, kept): (Vec<_>, Vec<_>) =
        packages.iter().partition(|package| package.is_published());
    // What packages hold is checked here; built, one by one, they would take many minutes.
    let mut pack = cargo(&["package", "--workspace", "--quiet", "--allow-dirty", "--no-verify"]);
    for package in kept {
        pack.args(["--exclude", package.name()]);
    }
    run_command(&mut pack)?;
    for package in published {
        run_command(&mut cargo(&["check", "--package", package.name()]))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::{STAGES, task};

    #[test]
    fn stages_are_skipped_by_the_names_they_print() {
        for stage in &STAGES {
            assert!(task().try_get_matches_from(["ci", "--skip", stage.name]).is_ok());
        }
        let both = task().try_get_matches_from(["ci", "--skip", "test,fuzz"]).unwrap();
        assert_eq!(both.get_many::<String>("skip").unwrap().count(), 2);
        assert!(task().try_get_matches_from(["ci", "--skip", "lunch"]).is_err());
    }
}
