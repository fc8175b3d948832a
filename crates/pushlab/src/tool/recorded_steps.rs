//! The steps of a recording set, with what was read for them.

use anyhow::Result;
use dataset::{
    Exclusion, IngestReport, IngestSettings, MANIFEST_NAME, Provenance, RecordingReport,
    RecordingSet, Table, ingest_each, provenance,
};

use crate::tool::origin::Input;
use crate::tool::terminal::Terminal;

/// Files of a set beside its recordings.
pub(crate) const SET_FILES: [&str; 2] = [MANIFEST_NAME, "sessions.csv"];

/// A step table fresh from recordings.
pub(crate) struct RecordedSteps {
    pub(crate) table: Table,
    pub(crate) inputs: Vec<Input>,
    /// Pushes that were found, with steps or without.
    pub(crate) n_pushes: usize,
}

impl RecordedSteps {
    /// Reads every recording of a set.
    ///
    /// # Errors
    /// If a recording or a file of the set cannot be read.
    pub(crate) fn read(
        set: &RecordingSet,
        settings: &IngestSettings,
        terminal: &Terminal,
    ) -> Result<Self> {
        for remark in set.remarks() {
            terminal.remark(&remark.text);
        }
        let mut rows = Vec::new();
        let mut progress = terminal.progress("recordings read:", set.recordings().len());
        let report = ingest_each(set, settings, |_, mut own| {
            rows.append(&mut own);
            progress.advance();
            Ok(())
        });
        progress.finish();
        let report = report?;
        if let Some(sentence) = excluded(&report) {
            terminal.remark(sentence);
        }
        let n_pushes = report.summary.pushes_used + report.summary.excluded.values().sum::<usize>();
        let mut provenance = provenance(set, &report);
        let inputs = recorded_inputs(set, &report, &mut provenance)?;
        Ok(Self { table: Table { rows, provenance }, inputs, n_pushes })
    }
}

/// How many pushes gave no steps, and why; nothing if all did.
fn excluded(report: &IngestReport) -> Option<String> {
    let reasons: Vec<_> =
        report.summary.excluded.iter().map(|(reason, n)| format!("{reason} in {n}")).collect();
    let n: usize = report.summary.excluded.values().sum();
    if n == 0 {
        return None;
    }
    let mut text = format!(
        "{n} of {} pushes are excluded: {}",
        n + report.summary.pushes_used,
        reasons.join(", ")
    );
    // Where other pushes touch, these do so by the manifest alone not.
    let nearest = |recording: &RecordingReport| match recording.excluded {
        Some(Exclusion::NoContact { smallest_gap_m }) => smallest_gap_m,
        _ => None,
    };
    let nearest = report.recordings.iter().filter_map(nearest);
    if let Some(nearest) =
        nearest.fold(None, |low: Option<f64>, gap| Some(low.map_or(gap, |low| low.min(gap))))
    {
        text += &format!(
            "; where there is no contact, the pusher stays {:.1} mm or more from the outline: if the \
             object moves there, the object's frame is off its outline, or [object], \
             pusher.radius_m or a transform under streams is wrong",
            1e3 * nearest
        );
    }
    Some(text)
}

/// What was read of a set: its files, which the provenance gets too, and its recordings.
///
/// # Errors
/// If a file of the set cannot be read.
pub(crate) fn recorded_inputs(
    set: &RecordingSet,
    report: &IngestReport,
    provenance: &mut Provenance,
) -> Result<Vec<Input>> {
    let mut inputs = Vec::new();
    for name in SET_FILES {
        let path = set.dir().join(name);
        if path.exists() && (set.preset().is_none() || name != MANIFEST_NAME) {
            let input = Input::file(&path)?;
            provenance.push("source", &format!("sha256 {} {name}", input.sha256));
            inputs.push(input);
        }
    }
    let mut read: Vec<_> =
        report.recordings.iter().filter(|recording| !recording.sha256.is_empty()).collect();
    // One file may hold several.
    read.dedup_by(|a, b| a.path == b.path);
    inputs.extend(
        read.iter().map(|recording| Input::known(&recording.path, recording.sha256.clone())),
    );
    Ok(inputs)
}
