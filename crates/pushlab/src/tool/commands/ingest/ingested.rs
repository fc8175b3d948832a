//! What an ingest gave, in words.

use std::fmt::Write as _;

use dataset::IngestReport;
use serde::Serialize;

use crate::tool::table_summary::TableSummary;
use crate::tool::terminal::WARNING;

/// The result beside the table itself.
#[derive(Serialize)]
#[serde(rename_all = "snake_case")]
pub(in crate::tool::commands) enum Ingested {
    /// Of recordings.
    Report(Box<IngestReport>),
    /// Of a table of others.
    Table(Box<TableSummary>),
}

/// Reasons that a screen has room for.
const MOST_REASONS: usize = 10;

impl Ingested {
    /// Everything, for the report.
    pub(super) fn full_text(&self) -> String {
        match self {
            Self::Report(report) => report.to_text(),
            Self::Table(summary) => summary.to_string(),
        }
    }

    /// What to know at once: the set, and what was excluded.
    pub(super) fn short_text(&self) -> String {
        match self {
            Self::Report(report) => report.summary_text() + &excluded(report),
            Self::Table(summary) => summary.to_string(),
        }
    }
}

/// What was excluded and why, one line each.
fn excluded(report: &IngestReport) -> String {
    let mut reasons = Vec::new();
    for recording in &report.recordings {
        reasons.extend(recording.excluded.iter().map(|why| (recording.name.clone(), why)));
        for push in &recording.pushes {
            let name = || format!("{} push {}", recording.name, push.push);
            reasons.extend(push.excluded.as_ref().map(|why| (name(), why)));
        }
    }
    let mut text = String::new();
    if !reasons.is_empty() {
        let _ = writeln!(text, "{WARNING}excluded{WARNING:#}");
    }
    for (name, why) in reasons.iter().take(MOST_REASONS) {
        let _ = writeln!(text, "  {name}: {why}");
    }
    if reasons.len() > MOST_REASONS {
        let more = reasons.len() - MOST_REASONS;
        let _ = writeln!(text, "  and {more} more; --report names them all");
    }
    text
}
