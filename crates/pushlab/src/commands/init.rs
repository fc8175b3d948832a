//! `pushlab init`: a first manifest from what a folder holds.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use anyhow::Result;
use dataset::Preset;
use serde::Serialize;

use crate::command_line::preset_parser;
use crate::origin::Origin;
use crate::terminal::{TITLE, Terminal, WARNING};

/// Write a commented dataset.toml from what a folder of recordings holds
///
/// Looks at topics, types, columns, rates and file names. What no recording can tell (shape, mass,
/// pusher) is left as "TODO". A dataset.toml that is there is never overwritten.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// Folder with the recordings, or with one folder of them
    dir: PathBuf,
    /// Write what is known of a public data set instead of looking
    #[arg(long, value_name = "NAME", value_parser = preset_parser())]
    preset: Option<Preset>,
    /// Print the file instead of writing it
    #[arg(long)]
    print: bool,
}

const EXAMPLES: &str = "\
Examples:
  pushlab init pushes
  pushlab init pushes --print
  pushlab init mit --preset mit-push     for the MIT push data set as published";

#[derive(Serialize)]
struct Initialized<'a> {
    /// The file written; none with `--print`.
    path: Option<&'a Path>,
    text: &'a str,
    /// Lines of the file that are still to be filled in, from 1.
    open_lines: Vec<usize>,
}

pub(crate) fn run(args: &Args, terminal: &Terminal) -> Result<()> {
    let mut arguments = vec!["init".to_owned(), args.dir.display().to_string()];
    if let Some(preset) = args.preset {
        arguments.extend(["--preset".to_owned(), preset.name().to_owned()]);
    }
    let (path, text) = if args.print {
        let text = match args.preset {
            Some(preset) => preset.text().to_owned(),
            None => dataset::draft_manifest(&args.dir)?,
        };
        (None, text)
    } else {
        let path = dataset::init(&args.dir, args.preset)?;
        let text = std::fs::read_to_string(&path)?;
        (Some(path), text)
    };
    let open_lines = text.lines().enumerate().filter(|(_, line)| line.contains("\"TODO\""));
    let result = Initialized {
        path: path.as_deref(),
        text: &text,
        open_lines: open_lines.map(|(index, _)| index + 1).collect(),
    };
    let words = match &path {
        Some(path) => next_steps(path, &result),
        None => text.clone(),
    };
    terminal.finish(&Origin::new(arguments), &result, words)
}

/// What was written and what to do now.
fn next_steps(path: &Path, result: &Initialized<'_>) -> String {
    let mut out = format!("{TITLE}wrote {}{TITLE:#}\n", path.display());
    let lines: Vec<_> = result.text.lines().collect();
    if !result.open_lines.is_empty() {
        let _ = writeln!(out, "{WARNING}to be filled in:{WARNING:#}");
    }
    for &line in &result.open_lines {
        let _ = writeln!(out, "  {}:{line}: {}", path.display(), lines[line - 1]);
    }
    let set = path.parent().filter(|dir| *dir != Path::new("")).unwrap_or(Path::new("."));
    let _ = writeln!(out, "then: pushlab ingest {} -o steps.csv", set.display());
    out
}
