//! `pushlab inspect`: what recordings contain.

use std::fmt;
use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use dataset::{
    DatasetError, Inspection, LogFormat, MANIFEST_NAME, ReadLimits, RecordingSet, Remark,
    StreamInfo, all_formats, find_recordings, unread_recordings,
};
use serde::Serialize;

use crate::tool::origin::{Input, Origin, plain, readable};
use crate::tool::terminal::{TITLE, Terminal, WARNING};

/// Tell what raw recordings contain: topics, types, columns, samples, rates, frames
///
/// Takes a recording set, a folder of recordings without a manifest, or one recording.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Args {
    /// Recording set, folder of recordings, or one recording
    set: PathBuf,
    /// Look into every recording, not only the first
    #[arg(long)]
    all: bool,
}

const EXAMPLES: &str = "\
Examples:
  pushlab inspect pushes
  pushlab inspect pushes --all
  pushlab inspect pushes/push-0000.mcap --json";

#[derive(Serialize)]
struct Inspected {
    /// Name of the log format, as in dataset.toml.
    format: &'static str,
    /// How many recordings there are.
    n_recordings: usize,
    /// What lies beside them and is not read.
    remarks: Vec<Remark>,
    /// Those that were looked into.
    recordings: Vec<InspectedRecording>,
}

#[derive(Serialize)]
struct InspectedRecording {
    path: PathBuf,
    #[serde(flatten)]
    inspection: Inspection,
}

pub(crate) fn run(args: &Args, terminal: &Terminal) -> Result<()> {
    let Found { format, paths, limits, remarks } = recordings(&args.set)?;
    let all = args.all.then(|| "--all".to_owned());
    let mut origin = Origin::new("inspect").path(&args.set).words(all);
    let wanted = if args.all { &paths[..] } else { &paths[..1] };
    let (format_id, n_recordings) = (format.id(), paths.len());
    let mut result = Inspected { format: format_id, n_recordings, remarks, recordings: Vec::new() };
    let mut progress = terminal.progress("inspected", wanted.len());
    for path in wanted {
        let inspection = format.inspect(path, &limits)?;
        origin.inputs.extend(Input::all(path)?);
        result.recordings.push(InspectedRecording { path: plain(path), inspection });
        progress.advance();
    }
    progress.finish();
    terminal.finish(&origin, &result, &result)
}

/// Recordings with their limits, and what lies beside them.
struct Found {
    format: &'static dyn LogFormat,
    paths: Vec<PathBuf>,
    limits: ReadLimits,
    remarks: Vec<Remark>,
}

/// The recordings of a set; of a folder that has no manifest, or one still to be filled in; or one.
fn recordings(path: &Path) -> Result<Found> {
    let is_dir = readable(path)?.is_dir();
    if path.join(MANIFEST_NAME).exists() || path.ends_with(MANIFEST_NAME) {
        match RecordingSet::open(path) {
            Ok(set) => {
                let (paths, remarks) = (set.recordings().to_vec(), set.remarks().to_vec());
                let limits = set.manifest().limits.clone();
                return Ok(Found { format: set.format(), paths, limits, remarks });
            }
            Err(DatasetError::Parse { .. } | DatasetError::Manifest { .. }) if is_dir => {}
            Err(error) => return Err(error.into()),
        }
    }
    if is_dir {
        let (format, folder, paths) = find_recordings(path)?;
        let remarks = unread_recordings(path, format, &folder);
        return Ok(Found { format, paths, limits: ReadLimits::default(), remarks });
    }
    for &format in all_formats() {
        if let Ok(paths) = format.find(path) {
            let (limits, remarks) = (ReadLimits::default(), Vec::new());
            return Ok(Found { format, paths, limits, remarks });
        }
    }
    let known: Vec<_> = all_formats().iter().map(|format| format.id()).collect();
    bail!(
        "{} is no recording of a known format ({}); for a step table see `pushlab describe`",
        path.display(),
        known.join(", ")
    )
}

impl fmt::Display for Inspected {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for recording in &self.recordings {
            write!(f, "{recording}")?;
        }
        for remark in &self.remarks {
            writeln!(f, "{WARNING}note:{WARNING:#} {}", remark.text)?;
        }
        let more = self.n_recordings - self.recordings.len();
        if more > 0 {
            writeln!(f, "{more} more recordings of format {}; --all shows them", self.format)?;
        }
        Ok(())
    }
}

impl fmt::Display for InspectedRecording {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{TITLE}{}{TITLE:#}", self.path.display())?;
        let head = ["stream", "type or columns", "samples", "Hz", "serves as"].map(str::to_owned);
        let cells: Vec<_> =
            std::iter::once(head).chain(self.inspection.streams.iter().map(cells)).collect();
        let widths: [usize; 5] = std::array::from_fn(|column| {
            cells.iter().map(|row| row[column].chars().count()).max().unwrap_or_default()
        });
        for row in &cells {
            let [name, kind, samples, rate, fits] = row;
            let [w0, w1, w2, w3, _] = widths;
            let line = format!("  {name:w0$}  {kind:w1$}  {samples:>w2$}  {rate:>w3$}  {fits}");
            writeln!(f, "{}", line.trim_end())?;
        }
        for (parent, child) in &self.inspection.frames {
            writeln!(f, "  frame {parent} <- {child}")?;
        }
        for remark in &self.inspection.remarks {
            writeln!(f, "  {WARNING}note:{WARNING:#} {}", remark.text)?;
        }
        Ok(())
    }
}

fn cells(stream: &StreamInfo) -> [String; 5] {
    let kind = match (stream.type_name.as_str(), stream.encoding.as_str()) {
        ("", _) => stream.columns.join(", "),
        (name, "") => name.to_owned(),
        (name, encoding) => format!("{name} ({encoding})"),
    };
    let fits: Vec<_> = stream.fits.iter().map(ToString::to_string).collect();
    [
        stream.name.clone(),
        kind,
        stream.count.to_string(),
        stream.rate_hz.map(|rate| format!("{rate:.0}")).unwrap_or_default(),
        fits.join(", "),
    ]
}
