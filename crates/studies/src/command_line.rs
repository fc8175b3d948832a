//! What the program `cargo run -p studies` is asked for.

use std::process::ExitCode;

use clap::{Parser, Subcommand};

use crate::{
    effects_atlas, figures, real_comparison, real_data, samples, simulated_and_real, thesis_claims,
};

/// Tasks of the project, which `cargo xtask` starts by their names.
#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask", max_term_width = 100)]
struct CommandLine {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    EffectsAtlas(effects_atlas::Args),
    RealComparison(real_comparison::Args),
    RealData(real_data::Args),
    ReproduceFigures(figures::Args),
    Samples(samples::Args),
    SimulatedAndReal(simulated_and_real::Args),
    ThesisClaims(thesis_claims::Args),
}

/// Does what the command line says, and tells on standard error why it cannot.
pub fn main() -> ExitCode {
    let result = match CommandLine::parse().task {
        Task::EffectsAtlas(args) => effects_atlas::run(&args),
        Task::RealComparison(args) => real_comparison::run(&args),
        Task::RealData(args) => real_data::run(&args),
        Task::ReproduceFigures(args) => figures::run(&args),
        Task::Samples(args) => samples::run(&args),
        Task::SimulatedAndReal(args) => simulated_and_real::run(&args),
        Task::ThesisClaims(args) => thesis_claims::run(&args),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {}", told(&error));
            ExitCode::FAILURE
        }
    }
}

/// An error with its causes, but for those that it says itself.
fn told(error: &anyhow::Error) -> String {
    error.chain().skip(1).map(ToString::to_string).fold(error.to_string(), |text, cause| {
        if text.ends_with(&cause) { text } else { format!("{text}: {cause}") }
    })
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::{CommandLine, told};

    #[test]
    fn a_cause_is_said_once() {
        let cause = || std::io::Error::other("no such file");
        let twice = anyhow::Error::new(cause()).context("cannot read x: no such file");
        assert_eq!(told(&twice), "cannot read x: no such file");
        let once = anyhow::Error::new(cause()).context("cannot read x");
        assert_eq!(told(&once), "cannot read x: no such file");
    }

    #[test]
    fn the_command_line_is_consistent() {
        CommandLine::command().debug_assert();
    }
}
