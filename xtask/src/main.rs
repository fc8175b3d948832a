//! Project tasks: `cargo xtask --help`.

mod cargo;
mod ci;
mod fmt;
mod starters;
mod test;
mod tidy;

use std::env;
use std::process::ExitCode;

use anyhow::Result;
use clap::{Command, FromArgMatches, Subcommand};

#[derive(Subcommand)]
enum Task {
    Ci(ci::Args),
    Fmt(fmt::Args),
    Test(test::Args),
    Tidy(tidy::Args),
}

fn main() -> ExitCode {
    let mut words = env::args_os().skip(1);
    let started = words.next().and_then(|task| starters::by_task(&task));
    let result = match started {
        Some(starter) => starter.start(words),
        None => run().map(|()| ExitCode::SUCCESS),
    };
    result.unwrap_or_else(|error| {
        eprintln!("error: {error:#}");
        ExitCode::FAILURE
    })
}

/// Runs a task of this program.
fn run() -> Result<()> {
    let matches = command_line().get_matches();
    match Task::from_arg_matches(&matches).unwrap_or_else(|error| error.exit()) {
        Task::Ci(args) => ci::run(&args),
        Task::Fmt(args) => fmt::run(&args),
        Task::Test(args) => test::run(&args),
        Task::Tidy(args) => tidy::run(&args),
    }
}

/// All tasks by their names: those of this program, and those that it starts.
fn command_line() -> Command {
    let program = Command::new("cargo xtask")
        .bin_name("cargo xtask")
        .max_term_width(100)
        .about("Project tasks: checks, tests, and what is made from the sources")
        .subcommand_required(true)
        .arg_required_else_help(true)
        .next_display_order(None);
    Task::augment_subcommands(program).subcommands(starters::commands())
}

#[cfg(test)]
mod tests {
    use super::command_line;

    #[test]
    fn the_command_line_is_consistent() {
        command_line().debug_assert();
    }
}
