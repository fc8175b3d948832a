//! `pushlab effects`: what a model may lack and a simulation may hide.

mod explain;
mod explanation;
mod list;

use anyhow::Result;
use clap::Subcommand;

use crate::tool::terminal::Terminal;

/// List and explain effects: what models can carry, and what `generate` can hide
#[derive(clap::Args)]
pub(crate) struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    List(list::Args),
    Explain(explain::Args),
}

pub(crate) fn run(args: &Args, terminal: &Terminal) -> Result<()> {
    match &args.command {
        Command::List(args) => list::run(args, terminal),
        Command::Explain(args) => explain::run(args, terminal),
    }
}
