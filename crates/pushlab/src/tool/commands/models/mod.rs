//! `pushlab models`: models and their files.

mod init;
mod list;
pub(super) mod parameters;
mod show;
mod surface;

pub(super) use self::parameters::Parameters;

use anyhow::Result;
use clap::Subcommand;

use crate::tool::terminal::Terminal;

/// Write, show and list models
#[derive(clap::Args)]
pub(crate) struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Init(init::Args),
    Show(show::Args),
    List(list::Args),
    Surface(surface::Args),
}

pub(crate) fn run(args: &Args, terminal: &Terminal) -> Result<()> {
    match &args.command {
        Command::Init(args) => init::run(args, terminal),
        Command::Show(args) => show::run(args, terminal),
        Command::List(args) => list::run(args, terminal),
        Command::Surface(args) => surface::run(args, terminal),
    }
}
