//! `pushlab init`: a first manifest from what a folder holds.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use anyhow::Result;
use dataset::{MANIFEST_NAME, Preset, Remark, draft_manifest, find_recordings, unread_recordings};
use serde::Serialize;

use crate::tool::command_line::preset_parser;
use crate::tool::destination::{Force, Inputs};
use crate::tool::file_ending;
use crate::tool::origin::{Input, Origin, plain, readable};
use crate::tool::terminal::{TITLE, Terminal, WARNING};

/// Write a commented dataset.toml from what a folder of recordings holds
///
/// Looks at topics, types, columns, rates and file names. What no recording can tell (shape, mass,
/// pusher) is left as "TODO".
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// Folder with the recordings, or with one folder of them
    dir: PathBuf,
    /// Write what is known of a public data set instead of looking
    #[arg(long, value_name = "NAME", value_parser = preset_parser())]
    preset: Option<Preset>,
    /// Where to write the file, by default dataset.toml in DIR; `-` is standard output
    #[arg(short, long, value_name = "FILE",
          value_parser = file_ending::or_standard(file_ending::model))]
    output: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
}

const EXAMPLES: &str = "\
Examples:
  pushlab init pushes
  pushlab init pushes -o -               to look at it first
  pushlab init mit --preset mit-push     for the MIT push data set as published";

#[derive(Serialize)]
struct Initialized<'a> {
    /// The file written.
    path: &'a Path,
    text: &'a str,
    /// Recordings that the file does not speak of.
    remarks: Vec<Remark>,
    /// Lines of the file that are still to be filled in, from 1.
    open_lines: Vec<usize>,
}

pub(crate) fn run(args: &Args, terminal: &Terminal) -> Result<()> {
    readable(&args.dir)?;
    let path = args.output.clone().unwrap_or_else(|| plain(&args.dir.join(MANIFEST_NAME)));
    let terminal = terminal.beside([path.as_path()])?;
    let destination = args.force.file(&path, &Inputs::default())?;
    let preset = args.preset.map(Preset::name);
    let mut origin = Origin::new("init").path(&args.dir).option("preset", preset);
    let (text, remarks) = match args.preset {
        Some(preset) => (preset.text().to_owned(), Vec::new()),
        None => drafted(&args.dir, &mut origin)?,
    };
    let text = format!("{}\n\n{}", text.trim_end(), origin.comment());
    destination.write(&text)?;
    let open_lines = text.lines().enumerate().filter(|(_, line)| line.contains("\"TODO\""));
    let result = Initialized {
        path: &path,
        text: &text,
        remarks,
        open_lines: open_lines.map(|(index, _)| index + 1).collect(),
    };
    terminal.finish(&origin, &result, next_steps(args, &result))
}

/// The text of a first manifest from what a folder holds, and recordings that it does not speak of.
///
/// # Errors
/// If there is no recording, or the first one cannot be read.
pub(super) fn drafted(dir: &Path, origin: &mut Origin) -> Result<(String, Vec<Remark>)> {
    let (format, folder, recordings) = find_recordings(dir)?;
    origin.inputs = Input::all(&recordings[0])?;
    Ok((draft_manifest(dir)?, unread_recordings(dir, format, &folder)))
}

/// What was written and what to do now.
fn next_steps(args: &Args, result: &Initialized<'_>) -> String {
    let path = result.path.display();
    let mut out = format!("{TITLE}wrote {path}{TITLE:#}\n");
    let lines: Vec<_> = result.text.lines().collect();
    if !result.open_lines.is_empty() {
        let _ = writeln!(out, "{WARNING}to be filled in:{WARNING:#}");
    }
    for &line in &result.open_lines {
        let _ = writeln!(out, "  {path}:{line}: {}", lines[line - 1]);
    }
    for remark in &result.remarks {
        let _ = writeln!(out, "{WARNING}note:{WARNING:#} {}", remark.text);
    }
    let set = args.dir.display();
    let _ = match (args.preset, Preset::of_recordings(&args.dir)) {
        (Some(Preset::MitTable), _) => {
            writeln!(out, "then: pushlab ingest {set}/TABLE.csv -o steps.csv")
        }
        (None, Some(known)) => {
            let name = known.name();
            writeln!(
                out,
                "or, as these look like public data: pushlab ingest {set} --preset {name}"
            )
        }
        _ => writeln!(out, "then: pushlab ingest {set} -o steps.csv"),
    };
    out
}
