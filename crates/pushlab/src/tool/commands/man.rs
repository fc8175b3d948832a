//! `pushlab man`: manual pages.

use std::path::PathBuf;

use anyhow::Result;
use clap::CommandFactory;

use crate::tool::command_line::CommandLine;
use crate::tool::destination::{Inputs, folder};
use crate::tool::file_ending;
use crate::tool::terminal::{TITLE, Terminal};

/// Write a manual page for each command
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// Folder for the pages; it may not have files in it
    #[arg(short, long, value_name = "DIR", value_parser = file_ending::folder)]
    output: PathBuf,
}

const EXAMPLES: &str = "\
Examples:
  pushlab man -o man1
  pushlab man -o ~/.local/share/man/man1";

pub(crate) fn run(args: &Args, terminal: &Terminal) -> Result<()> {
    let destination = folder(&args.output, &Inputs::default())?;
    destination.fill(|part| -> Result<()> {
        Ok(clap_mangen::generate_to(CommandLine::command(), part.path())?)
    })?;
    let path = args.output.display();
    terminal.print_for_people(&format!("{TITLE}wrote {path}{TITLE:#}\n"))
}
