//! `cargo xtask real-comparison`: the models against public measurements, on a page.

mod corner;
mod known_supports;
mod learned;
mod page;
mod plain_fit;
mod shapes;
mod shared_outputs;
mod source;
mod supports;

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use clap::ValueEnum;

/// Compares the models with public measurements and writes the page about it.
#[derive(clap::Args)]
pub struct Args {
    /// Folder with the public data sets (`mit-push-table`, `mit-push-raw`, `mit-push-endpoints`)
    #[arg(long, value_name = "DIR")]
    data: PathBuf,
    /// Folder for `real-data.md` and its picture
    #[arg(short, long, value_name = "DIR", default_value = "docs", alias = "out")]
    output: PathBuf,
    /// Write these sections anew, and leave the page's others as they are
    #[arg(long, value_delimiter = ',')]
    only: Vec<Part>,
}

/// A section of the page.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Part {
    /// The analytical model on the one-step pushes
    Table,
    /// Every model that learns, on the same
    Learned,
    /// Three outputs of the same, each alone and together
    SharedOutputs,
    /// Physics alone on the same: feet, caught tips, scatter
    Supports,
    /// The analytical model on the raw pushes
    Raw,
    /// Physics alone on long pushes of which the ends are known: feet, gaps
    Shapes,
    /// The same pushes by the diagnosis alone, half by half
    DiagnosedShapes,
    /// Physics alone on an object that stands on known feet
    KnownSupports,
}

/// Writes the page, or some of its sections anew.
///
/// # Errors
/// Data that cannot be read; a comparison that fails; a page that cannot be read or written.
pub fn run(args: &Args) -> Result<()> {
    let page = args.output.join("real-data.md");
    let mut text = page::HEAD.to_owned();
    if !args.only.is_empty() {
        let old = std::fs::read_to_string(&page);
        let old = old.with_context(|| format!("cannot read {}", page.display()))?;
        text += page::sections(&old);
    }
    for part in Part::value_variants() {
        let section = match part {
            _ if args.only.is_empty() || args.only.contains(part) => part.text(args)?,
            _ => continue,
        };
        text = if args.only.is_empty() { text + &section } else { page::with(&text, &section)? };
    }
    write(&page, &text)?;
    println!("written: {}", page.display());
    Ok(())
}

impl Part {
    fn text(self, args: &Args) -> Result<String> {
        let table = args.data.join("mit-push-table/table.csv");
        Ok(match self {
            Self::Table => {
                let table = source::one_step_table(&table)?;
                let corner = corner::Corner::of(&table)?;
                write(&args.output.join("real-data-corner.svg"), &corner.picture(&table)?)?;
                page::one_step_text(&table, &corner)
            }
            Self::Learned => learned::Learned::of(&table)?.text(),
            Self::SharedOutputs => shared_outputs::SharedOutputs::of(&table)?.text(),
            Self::Supports => {
                let found = supports::Supports::of(&table)?;
                write(&args.output.join("real-data-error.svg"), &found.falling()?)?;
                write(&args.output.join("real-data-feet.svg"), &found.feet()?)?;
                found.text()
            }
            Self::Raw => page::raw_text(&source::raw_pushes(&args.data.join("mit-push-raw"))?),
            Self::Shapes => {
                let found = shapes::shapes(&args.data.join("mit-push-endpoints/plywood.csv"))?;
                write(&args.output.join("real-data-shapes.svg"), &shapes::picture(&found)?)?;
                shapes::text(&found)
            }
            Self::DiagnosedShapes => {
                let ends = args.data.join("mit-push-endpoints/plywood.csv");
                shapes::diagnosed_text(&shapes::diagnosed(&ends)?)
            }
            Self::KnownSupports => {
                let found = known_supports::known_supports(&args.data.join("cmu-known-supports"))?;
                let picture = known_supports::picture(&found)?;
                write(&args.output.join("real-data-known-supports.svg"), &picture)?;
                known_supports::text(&found)
            }
        })
    }
}

/// Writes a whole file, in a folder that is made where it is missing.
fn write(path: &Path, text: &str) -> Result<()> {
    let folder = path.parent().unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder)
        .with_context(|| format!("cannot create {}", folder.display()))?;
    Ok(output::write(path, text)?)
}
