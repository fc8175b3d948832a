//! `cargo xtask fmt`: formats every source file.

use anyhow::Result;

use crate::cargo::{cargo, run as run_command};
use crate::tidy;

/// Format every source file, also those that `cargo fmt` does not find: a list declares them.
#[derive(clap::Args, Default)]
pub(crate) struct Args {
    /// Change nothing, and fail where something is not formatted
    #[arg(long)]
    pub(crate) check: bool,
}

/// Formats, or checks.
///
/// # Errors
/// A file that cannot be read or, for a check, is not formatted.
pub(crate) fn run(args: &Args) -> Result<()> {
    let mut command = cargo(&["fmt", "--all"]);
    if args.check {
        command.arg("--check");
    }
    // rustfmt follows `mod` lines, and expands no macro that makes them.
    run_command(command.arg("--").args(tidy::listed_files()?))
}
