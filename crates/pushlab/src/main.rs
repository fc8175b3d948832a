//! The command-line tool `pushlab`: reads the arguments, runs one command, says what went wrong.

mod command_line;
mod commands;
mod destination;
mod diagnosis_file;
mod document;
mod failure;
mod file_ending;
mod fitting;
mod global;
mod known;
mod opened;
mod origin;
mod people;
mod progress;
mod recorded_steps;
mod rig;
mod some_of;
mod speed;
mod step_kind;
mod step_size;
mod step_source;
mod suspected;
mod table_summary;
mod terminal;
mod unexplained;
mod whole_pushes;
mod wrong_usage;

use std::process::ExitCode;

use clap::FromArgMatches;

use crate::command_line::CommandLine;
use crate::failure::Outcome;
use crate::terminal::Terminal;

fn main() -> ExitCode {
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
