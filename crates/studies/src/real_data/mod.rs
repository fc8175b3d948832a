//! `cargo xtask real-data`: the models against published measurements, beside published numbers.

mod end_points;
mod limit_surface_fits;
mod motorcycle;
mod one_step;
mod raw_pushes;
mod recordings;
mod row;
mod samples;

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use serde_json::{Map, Value};

use row::Row;

/// Runs the models on published measurements and compares with the numbers to expect.
#[derive(clap::Args)]
pub struct Args {
    /// Folder with the public data sets (`mit-push-table`, `mit-push-endpoints`, …)
    #[arg(long, value_name = "DIR")]
    data: PathBuf,
    /// Folder for `real-data.json`
    #[arg(short, long, value_name = "DIR", default_value = "target/real-data", alias = "out")]
    output: PathBuf,
    /// Random splits of the table into training and test steps
    #[arg(short = 'n', long, value_name = "N", default_value_t = 10)]
    splits: u64,
    /// Seed of the splits
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    seed: u64,
}

/// What one part of the report found: its keys in the file, and its rows for people.
#[derive(Default)]
struct Section {
    json: Map<String, Value>,
    rows: Vec<Row>,
}

/// Writes `real-data.json`, and prints the same as a table.
///
/// # Errors
/// Data that cannot be read; a number that cannot be computed; a file that cannot be written.
pub fn run(args: &Args) -> Result<()> {
    let mut json = Map::new();
    let mut rows = Vec::new();
    let end_points = args.data.join("mit-push-endpoints");
    let fits = limit_surface_fits::fits(&end_points.join("wrench_twist_plywood.csv"))?;
    for section in [
        one_step::run(&args.data.join("mit-push-table/table.csv"), args.splits, args.seed)?,
        limit_surface_fits::section(&fits),
        end_points::run(&end_points.join("plywood.csv"), &fits)?,
        raw_pushes::run(&args.data.join("mit-push-raw"))?,
        recordings::run(&args.data.join("mit-recordings"))?,
        motorcycle::run(&args.data.join("gp/mcycle/mcycle.csv"))?,
        samples::run(&args.data.join("../samples"))?,
    ] {
        json.extend(section.json);
        rows.extend(section.rows);
    }
    print!("{}", row::table(&rows));
    let path = args.output.join("real-data.json");
    write(&path, &serde_json::to_string_pretty(&Value::Object(json))?)?;
    println!("written: {}", path.display());
    let outside: Vec<String> = rows.iter().filter_map(Row::complaint).collect();
    if outside.is_empty() {
        return Ok(());
    }
    bail!("{} numbers are not as expected:\n{}", outside.len(), outside.join("\n"))
}

/// Writes a whole file, in a folder that is made where it is missing.
fn write(path: &Path, text: &str) -> Result<()> {
    let folder = path.parent().unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder)
        .with_context(|| format!("cannot create {}", folder.display()))?;
    Ok(output::write(path, text)?)
}
