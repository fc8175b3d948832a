//! Options of every command.

use clap::{ColorChoice, value_parser};

const GENERAL: &str = "Options of every command";

/// Options of every command.
#[derive(clap::Args)]
pub(crate) struct Global {
    /// Print the result as JSON on standard output, and nothing for people
    #[arg(long, global = true, help_heading = GENERAL)]
    pub(crate) json: bool,
    /// Say nothing but warnings and errors
    #[arg(short, long, global = true, help_heading = GENERAL)]
    pub(crate) quiet: bool,
    /// Say more on standard error: what was read, and how long it took
    #[arg(short, long, global = true, conflicts_with = "quiet", help_heading = GENERAL)]
    pub(crate) verbose: bool,
    /// When to use colors; `auto` is on a terminal, unless NO_COLOR is set
    #[arg(long, global = true, value_name = "WHEN", default_value = "auto",
          help_heading = GENERAL)]
    pub(crate) color: ColorChoice,
    /// Threads to use, all processors without it; the result does not depend on it
    #[arg(short, long, global = true, value_name = "N",
          value_parser = value_parser!(u16).range(1..=1024), help_heading = GENERAL)]
    pub(crate) jobs: Option<u16>,
}
