//! What a simulation wrote, in words.

use std::fmt;
use std::path::PathBuf;

use plant::GenerateReport;
use serde::Serialize;

use super::Args;
use crate::tool::origin::plain;
use crate::tool::terminal::TITLE;

/// The set, its truth, and how much there is of it.
#[derive(Serialize)]
pub(super) struct Generated {
    /// The set's folder.
    set: PathBuf,
    /// The file with the truth.
    sealed_truth: PathBuf,
    shape: String,
    format: String,
    n_pushes: usize,
    /// Pushes of the grid left out because the tip would have begun inside the object.
    n_blocked: usize,
    /// Pushes left out because the object tipped over or the motion could not be followed: name and reason.
    not_made: Vec<(String, String)>,
    /// Time that the pushes take on the rig.
    rig_time_s: f64,
}

impl Generated {
    pub(super) fn new(report: &GenerateReport, args: &Args) -> Self {
        Self {
            set: plain(&report.set),
            sealed_truth: plain(&report.sealed_truth),
            shape: args.shape.to_string(),
            format: args.format.clone(),
            n_pushes: report.n_pushes,
            n_blocked: report.n_blocked,
            not_made: report.not_made.clone(),
            rig_time_s: report.rig_time,
        }
    }
}

impl fmt::Display for Generated {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { set, sealed_truth, shape, format, n_pushes, n_blocked, not_made, rig_time_s } =
            self;
        let (set, sealed_truth) = (set.display(), sealed_truth.display());
        writeln!(f, "{TITLE}wrote {set}{TITLE:#}")?;
        writeln!(f, "  {n_pushes} pushes of {shape} as {format}, {rig_time_s:.0} s on the rig")?;
        if *n_blocked > 0 {
            writeln!(f, "  {n_blocked} of the grid left out: the tip would begin in the object")?;
        }
        for (name, why) in not_made {
            writeln!(f, "  {name} left out: {why}")?;
        }
        writeln!(f, "  the truth is sealed in {sealed_truth}")?;
        writeln!(f, "then: pushlab ingest {set} -o steps.csv")
    }
}
