//! `cargo xtask real-comparison`: the analytical model against public measurements, on a page.

mod corner;
mod ends;
mod page;
mod source;

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};

/// Compares the analytical model with public measurements and writes the page about it.
#[derive(clap::Args)]
pub(crate) struct Args {
    /// Folder with the public data sets (`mit-push-table`, `mit-push-raw`, `mit-push-endpoints`)
    #[arg(long)]
    data: PathBuf,
    /// Folder for `real-data.md` and its picture
    #[arg(long, default_value = "docs")]
    out: PathBuf,
}

pub(crate) fn run(args: &Args) -> Result<()> {
    let table = source::one_step_table(&args.data.join("mit-push-table/table.csv"))?;
    let raw = source::raw_pushes(&args.data.join("mit-push-raw"))?;
    let ends = ends::ends(&args.data.join("mit-push-endpoints/plywood.csv"))?;
    let corner = corner::Corner::of(&table)?;
    let picture = args.out.join("real-data-corner.svg");
    write_whole(&picture, &corner.picture(&table)?)?;
    let page = args.out.join("real-data.md");
    write_whole(&page, &page::text(&table, &corner, &raw, &ends))?;
    println!("written: {} and {}", page.display(), picture.display());
    Ok(())
}

/// Writes under a temporary name and renames, so that a killed run leaves no half file.
fn write_whole(path: &Path, text: &str) -> Result<()> {
    let temporary = path.with_added_extension("part");
    let write = || {
        std::fs::create_dir_all(path.parent().unwrap_or(Path::new(".")))?;
        std::fs::write(&temporary, text)?;
        std::fs::rename(&temporary, path)
    };
    write().with_context(|| format!("cannot write {}", path.display()))
}
