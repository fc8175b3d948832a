//! `cargo xtask fmt`: formats every source file.

use anyhow::Result;
use clap::{Arg, ArgAction, Command as Task};

use crate::cargo::{cargo, run as run_command};
use crate::tidy;

/// The task's name, help and options.
pub(crate) fn task() -> Task {
    let check = Arg::new("check")
        .long("check")
        .action(ArgAction::SetTrue)
        .help("Change nothing, and fail where something is not formatted");
    Task::new("fmt")
        .about(
            "Format every source file, also those that `cargo fmt` does not find: a list declares them",
        )
        .arg(check)
}

/// Formats, or only checks.
///
/// # Errors
/// A file that cannot be read or, for a check, is not formatted.
pub(crate) fn run(check: bool) -> Result<()> {
    let mut command = cargo(&["fmt", "--all"]);
    if check {
        command.arg("--check");
    }
    // rustfmt follows `mod` lines, and expands no macro that makes them.
    run_command(command.arg("--").args(tidy::listed_files()?))
}
