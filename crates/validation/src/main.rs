//! Validation as a program: `cargo run -p validation -- --help`.

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use validation::{rig_calibration, trials};

/// Tasks of the project, which `cargo xtask` starts by their names.
#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask", max_term_width = 100)]
struct CommandLine {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    DiagnosisTrials(trials::Args),
    RigCalibration(rig_calibration::Args),
}

fn main() -> ExitCode {
    let result = match CommandLine::parse().task {
        Task::DiagnosisTrials(args) => trials::run(&args),
        Task::RigCalibration(args) => rig_calibration::run(&args),
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
