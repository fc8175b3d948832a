//! Project tasks: `cargo xtask --help`.

#![forbid(unsafe_code)]

mod bench;
mod cargo;
mod ci;
mod effects_atlas;
mod figures;
mod fixtures;
mod fuzz;
mod held_out;
mod learned_kinds;
mod real_comparison;
mod real_data;
mod residual_grid;
mod samples;
mod simulated_and_real;
mod test;
mod tidy;
mod trials;

use std::process::ExitCode;

use clap::{Parser, Subcommand};

/// Project tasks: checks, tests, and what is made from the sources.
#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask")]
struct CommandLine {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    Bench(bench::Args),
    Ci(ci::Args),
    DiagnosisTrials(trials::Args),
    EffectsAtlas(effects_atlas::Args),
    Fixtures(fixtures::Args),
    Fuzz(fuzz::Args),
    #[command(hide = true)]
    FuzzWorker(fuzz::WorkerArgs),
    RealComparison(real_comparison::Args),
    RealData(real_data::Args),
    ReproduceFigures(figures::Args),
    Samples(samples::Args),
    SimulatedAndReal(simulated_and_real::Args),
    Test(test::Args),
    Tidy(tidy::Args),
}

fn main() -> ExitCode {
    let result = match CommandLine::parse().task {
        Task::Bench(args) => bench::run(&args),
        Task::Ci(args) => ci::run(&args),
        Task::DiagnosisTrials(args) => trials::run(&args),
        Task::EffectsAtlas(args) => effects_atlas::run(&args),
        Task::Fixtures(args) => fixtures::run(&args),
        Task::Fuzz(args) => fuzz::run(&args),
        Task::FuzzWorker(args) => fuzz::work(&args),
        Task::RealComparison(args) => real_comparison::run(&args),
        Task::RealData(args) => real_data::run(&args),
        Task::ReproduceFigures(args) => figures::run(&args),
        Task::Samples(args) => samples::run(&args),
        Task::SimulatedAndReal(args) => simulated_and_real::run(&args),
        Task::Test(args) => test::run(&args),
        Task::Tidy(args) => tidy::run(&args),
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
