//! What the program `cargo run -p benchmarks` is asked for.

use std::process::ExitCode;

use clap::{Parser, Subcommand};

use crate::bench;

/// Tasks of the project, which `cargo xtask` starts by their names.
#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask", max_term_width = 100)]
struct CommandLine {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    Bench(bench::Args),
}

/// Does what the command line says, and tells on standard error why it cannot.
pub fn main() -> ExitCode {
    let result = match CommandLine::parse().task {
        Task::Bench(args) => bench::run(&args),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::CommandLine;

    #[test]
    fn the_command_line_is_consistent() {
        CommandLine::command().debug_assert();
    }
}
