//! The fuzzing task as a program: `cargo run -p fuzzing -- --help`.

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Tasks of the project, which `cargo xtask` starts by their names.
#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask", max_term_width = 100)]
struct CommandLine {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    Fuzz(fuzzing::Args),
    #[command(hide = true)]
    FuzzWorker(fuzzing::WorkerArgs),
}

fn main() -> ExitCode {
    let result = match CommandLine::parse().task {
        Task::Fuzz(args) => fuzzing::run(&args),
        Task::FuzzWorker(args) => fuzzing::work(&args),
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
