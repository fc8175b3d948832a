//! The program `pushlab`: reads the arguments, runs one command, says what went wrong.

use std::process::ExitCode;

use clap::FromArgMatches;

use crate::tool::command_line::{self, CommandLine};
use crate::tool::failure::{self, Outcome};
use crate::tool::terminal::Terminal;

/// Runs the command that the arguments of this process name, on its terminal; its exit code is 0 for
/// done, 1 for an input or a computation that failed, 2 for wrong usage.
pub fn program() -> ExitCode {
    let arguments: Vec<_> = std::env::args_os().collect();
    let mut command = command_line::command(&arguments);
    let parsed = command
        .try_get_matches_from_mut(arguments)
        .and_then(|matches| CommandLine::from_arg_matches(&matches));
    let outcome = match parsed {
        Ok(command_line) => {
            let terminal = Terminal::new(&command_line.global);
            match command_line.run(&terminal) {
                Ok(()) => Outcome::Done,
                Err(error) => failure::report(&error, &terminal),
            }
        }
        // Help and version are errors to the parser; it knows where they belong and their code.
        Err(error) => {
            let _ = error.print();
            if error.use_stderr() { Outcome::WrongUsage } else { Outcome::Done }
        }
    };
    outcome.into()
}
