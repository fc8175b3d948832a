//! The commands: one file each, with its arguments and its work, and one list.

mod add;
mod calibrate;
mod check;
mod compare;
mod completions;
mod demo;
mod describe;
mod diagnose;
mod effects;
mod fit;
mod generate;
mod ingest;
mod init;
mod inspect;
mod man;
mod merge;
mod models;
mod report;
mod run;
mod simulate;
mod statistics;
mod suggest;
mod track;
mod train;

use anyhow::Result;
use clap::Subcommand;

use crate::tool::terminal::Terminal;

/// Every command, in the order of their first use.
#[derive(Subcommand)]
pub(crate) enum Command {
    Demo(demo::Args),
    Run(run::Args),
    Init(init::Args),
    Inspect(inspect::Args),
    #[command(visible_alias = "table")]
    Ingest(ingest::Args),
    Merge(merge::Args),
    Describe(describe::Args),
    Models(models::Args),
    Effects(effects::Args),
    Generate(generate::Args),
    Check(check::Args),
    Compare(compare::Args),
    Statistics(statistics::Args),
    Diagnose(diagnose::Args),
    Fit(fit::Args),
    Add(add::Args),
    Calibrate(calibrate::Args),
    Suggest(suggest::Args),
    Train(train::Args),
    Simulate(simulate::Args),
    Track(track::Args),
    Report(report::Args),
    Completions(completions::Args),
    Man(man::Args),
}

impl Command {
    /// Runs the command.
    ///
    /// # Errors
    /// What the command says.
    pub(crate) fn run(&self, terminal: &Terminal) -> Result<()> {
        match self {
            Self::Demo(args) => demo::run(args, terminal),
            Self::Run(args) => run::run(args, terminal),
            Self::Init(args) => init::run(args, terminal),
            Self::Inspect(args) => inspect::run(args, terminal),
            Self::Ingest(args) => ingest::run(args, terminal),
            Self::Merge(args) => merge::run(args, terminal),
            Self::Describe(args) => describe::run(args, terminal),
            Self::Models(args) => models::run(args, terminal),
            Self::Effects(args) => effects::run(args, terminal),
            Self::Generate(args) => generate::run(args, terminal),
            Self::Check(args) => check::run(args, terminal),
            Self::Compare(args) => compare::run(args, terminal),
            Self::Statistics(args) => statistics::run(args, terminal),
            Self::Diagnose(args) => diagnose::run(args, terminal),
            Self::Fit(args) => fit::run(args, terminal),
            Self::Add(args) => add::run(args, terminal),
            Self::Calibrate(args) => calibrate::run(args, terminal),
            Self::Suggest(args) => suggest::run(args, terminal),
            Self::Train(args) => train::run(args, terminal),
            Self::Simulate(args) => simulate::run(args, terminal),
            Self::Track(args) => track::run(args, terminal),
            Self::Report(args) => report::run(args, terminal),
            Self::Completions(args) => completions::run(args, terminal),
            Self::Man(args) => man::run(args, terminal),
        }
    }
}
