//! `pushlab completions`: completion scripts for shells.

use anyhow::Result;
use clap::CommandFactory;
use clap_complete::Shell;

use crate::tool::command_line::CommandLine;
use crate::tool::terminal::Terminal;

/// Print a completion script for a shell
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// The shell
    shell: Shell,
}

const EXAMPLES: &str = "\
Examples:
  pushlab completions bash > ~/.local/share/bash-completion/completions/pushlab
  pushlab completions zsh > ~/.zfunc/_pushlab
  pushlab completions fish > ~/.config/fish/completions/pushlab.fish";

pub(crate) fn run(args: &Args, terminal: &Terminal) -> Result<()> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut CommandLine::command(), "pushlab", &mut script);
    terminal.print(&String::from_utf8(script)?)
}
