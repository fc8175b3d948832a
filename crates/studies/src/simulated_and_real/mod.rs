//! `cargo xtask simulated-and-real`: the simulated table of steps beside a measured one.

mod cells;
mod described;
mod figure;
mod page;
mod words;

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use dataset::TableMapping;
use plant::Profile;

use crate::figures::inputs::Inputs;
use crate::figures::models::steps::Steps;
use crate::figures::{named, rigs, thesis_design};
use described::Described;
use fixtures::workspace_root;

/// Name of the page and of its picture.
const NAME: &str = "simulated-and-real";
/// Where the page of the documentation stands, and the rig that it is about.
const DOCS: &str = "docs";
const RIG: &str = Profile::DEFAULT;

/// Put the simulated table of the thesis' design beside a measured one, in docs/.
#[derive(clap::Args)]
pub struct Args {
    /// Table of measured steps, as `mit-push-table/table.csv`; without it the
    /// simulated numbers are printed alone, and nothing is written
    #[arg(long, value_name = "PATH")]
    data: Option<PathBuf>,
    /// How rough the simulated rig is
    #[arg(long, value_name = "NAME", default_value = RIG, value_parser = rigs())]
    rig: String,
    /// Folder for the page and its picture; for another rig or table not docs, whose page is of these
    #[arg(short, long, value_name = "DIR", default_value = DOCS, alias = "out")]
    output: PathBuf,
}

/// Describes both tables and writes the page, or prints what is simulated.
///
/// # Errors
/// Data that cannot be read; a folder whose page is of other data or another rig; a model that cannot be
/// learned; a file that cannot be written.
pub fn run(args: &Args) -> Result<()> {
    let out = workspace_root().join(&args.output);
    let inputs = args.data.as_ref().map(|path| Inputs::open(path, false)).transpose()?;
    if let Some(inputs) = &inputs {
        let is_documented = args.rig == RIG && inputs.name() == TableMapping::mit_table()?.name;
        keep_documentation(&workspace_root().join(DOCS), &out, is_documented)?;
    }
    let sets = thesis_design(named(&args.rig)?)?;
    let slowest = sets.into_iter().next().context("a design has a slowest speed")?;
    let simulated = Steps::of(&Inputs::open(&slowest, false)?)?;
    let described = Described::of("simulated", &simulated)?;
    let Some(inputs) = inputs else {
        print!("{}", page::table(&[described]));
        return Ok(());
    };
    let measured = Steps::of(&inputs)?;
    let both = [Described::of("measured", &measured)?, described];
    let picture = figure::draw([&measured.steps, &simulated.steps], &both).svg()?;
    write(&out.join(NAME).with_extension("svg"), &picture)?;
    let cells = cells::common([&measured.steps, &simulated.steps]);
    let paired = cells::paired(&measured.steps, &simulated.steps);
    let text = page::page(inputs.name(), &both, &cells, &paired);
    write(&out.join(NAME).with_extension("md"), &text)
}

/// Refuses to put a page of another rig, or of other data, in the place of the documentation's.
fn keep_documentation(docs: &Path, out: &Path, is_documented: bool) -> Result<()> {
    let page = docs.join(NAME).with_extension("md");
    let is_same = out.canonicalize().is_ok_and(|out| docs.canonicalize().is_ok_and(|d| d == out));
    ensure!(
        is_documented || !is_same || !page.exists(),
        "{} is about the rig `{RIG}` and the table of the preset mit-table; name another folder with \
         --output",
        page.display()
    );
    Ok(())
}

fn write(path: &Path, text: &str) -> Result<()> {
    output::write(path, text)?;
    println!("written: {}", path.display());
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::keep_documentation;

    #[test]
    fn the_page_of_the_documentation_is_made_anew_by_its_own_rig_and_table_alone() {
        let dir = tempfile::tempdir().unwrap();
        let (docs, other) = (dir.path().join("docs"), dir.path().join("other"));
        fs::create_dir_all(&docs).unwrap();
        // There is nothing to keep.
        keep_documentation(&docs, &docs, false).unwrap();
        fs::write(docs.join("simulated-and-real.md"), "# Rough\n").unwrap();
        keep_documentation(&docs, &docs, true).unwrap();
        keep_documentation(&docs, &other, false).unwrap();
        let same = [docs.clone(), dir.path().join("docs/../docs/.")];
        for out in same {
            let refused = keep_documentation(&docs, &out, false).unwrap_err().to_string();
            assert!(
                refused.contains("docs/simulated-and-real.md is about the rig `rough`"),
                "{refused}"
            );
            assert!(refused.contains("--output"), "{refused}");
        }
    }
}
