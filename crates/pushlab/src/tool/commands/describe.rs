//! `pushlab describe`: what a step table holds.

use std::path::PathBuf;

use anyhow::Result;
use dataset::Table;

use crate::tool::file_ending;
use crate::tool::origin::{Input, Origin, readable};
use crate::tool::table_summary::TableSummary;
use crate::tool::terminal::Terminal;

/// Tell what a step table holds: rows, shapes, flags, coverage, and what made it
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// Step table, .csv or .parquet
    #[arg(value_parser = file_ending::table)]
    table: PathBuf,
}

const EXAMPLES: &str = "\
Examples:
  pushlab describe steps.csv
  pushlab describe steps.parquet --json";

pub(crate) fn run(args: &Args, terminal: &Terminal) -> Result<()> {
    readable(&args.table)?;
    let table = Table::read(&args.table)?;
    let mut origin = Origin::new("describe").path(&args.table);
    origin.inputs = vec![Input::file(&args.table)?];
    let summary = TableSummary::of(&table);
    terminal.finish(&origin, &summary, &summary)
}
