//! Project tasks: `cargo xtask --help`.

mod cargo;
mod ci;
mod dependencies;
mod fmt;
mod packages;
mod starters;
mod test;
mod tidy;

use std::env;
use std::process::ExitCode;

use anyhow::{Result, bail};
use clap::Command;

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
    match matches.subcommand() {
        Some(("ci", options)) => ci::run(options),
        Some(("fmt", options)) => fmt::run(options.get_flag("check")),
        Some(("test", _)) => test::run(),
        Some(("tidy", options)) if options.get_flag("list") => {
            tidy::list();
            Ok(())
        }
        Some(("tidy", _)) => tidy::run(),
        task => bail!("there is no task {task:?}"),
    }
}

/// All tasks by their names: those of this program, and those that it starts.
fn command_line() -> Command {
    Command::new("cargo xtask")
        .bin_name("cargo xtask")
        .max_term_width(100)
        .about("Project tasks: checks, tests, and what is made from the sources")
        .subcommand_required(true)
        .arg_required_else_help(true)
        .next_display_order(None)
        .subcommands([ci::task(), fmt::task(), test::task(), tidy::task()])
        .subcommands(starters::commands())
}

#[cfg(test)]
mod tests {
    use super::command_line;

    #[test]
    fn the_command_line_is_consistent() {
        command_line().debug_assert();
    }
}
