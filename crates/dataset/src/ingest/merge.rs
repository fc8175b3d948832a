//! Parts of a set that were ingested apart become what one ingest of the whole set gives.

use crate::error::DatasetError;
use crate::ingest::collected::Collected;
use crate::ingest::report::{IngestReport, RecordingReport, Summary};
use crate::table::step::StepRow;

/// Puts the reports of all parts of a set together, in any order, and hands the rows of each recording to a
/// sink, as [`ingest_each`](crate::ingest_each) does for the whole set: the same rows and the same report.
///
/// - `rows_of`: the rows of the part whose report is the so-manieth of those given; one part's are in memory
///   at a time.
///
/// # Errors
/// `Parts` for parts that are missing, there twice, or of sets or settings that differ, and for rows that are
/// not those of their report; `NothingUsable` if no push gave rows; what `rows_of` and the sink return.
pub fn merge_each(
    parts: Vec<IngestReport>,
    mut rows_of: impl FnMut(usize) -> Result<Vec<StepRow>, DatasetError>,
    mut sink: impl FnMut(&RecordingReport, Vec<StepRow>) -> Result<(), DatasetError>,
) -> Result<IngestReport, DatasetError> {
    let parts = in_order(parts)?;
    let Some((_, first)) = parts.first() else {
        return Err(parts_error("no part is given".to_owned()));
    };
    let mut report = IngestReport {
        part: None,
        summary: Summary::default(),
        recordings: Vec::new(),
        ..first.clone()
    };
    let mut collected = Collected::default();
    for (index, part) in parts {
        let name = named(&part);
        let mut rows = rows_of(index)?.into_iter();
        for recording in part.recordings {
            let n = recording.pushes.iter().map(|push| push.rows).sum();
            let own: Vec<StepRow> = rows.by_ref().take(n).collect();
            if own.len() != n || own.iter().any(|row| *row.recording != *recording.name) {
                return Err(other_rows(&name, &recording.name));
            }
            collected.add(&own, &recording);
            sink(&recording, own)?;
            report.recordings.push(recording);
        }
        if let Some(row) = rows.next() {
            return Err(other_rows(&name, &row.recording));
        }
    }
    collected.finish(&mut report);
    match report.summary.pushes_used {
        0 => Err(report.nothing_usable(report.name.as_ref())),
        _ => Ok(report),
    }
}

/// The parts in the order of their recordings, each with its place among those given.
fn in_order(parts: Vec<IngestReport>) -> Result<Vec<(usize, IngestReport)>, DatasetError> {
    let mut parts: Vec<_> = parts.into_iter().enumerate().collect();
    parts.sort_by_key(|(_, report)| report.part);
    let Some((_, first)) = parts.first() else { return Ok(parts) };
    for (_, other) in &parts {
        let is_of_one = first.part.map(|part| part.of()) == other.part.map(|part| part.of());
        let differs = [
            ("the number of parts", !is_of_one),
            ("tool", first.tool != other.tool),
            ("set", first.name != other.name),
            ("preset", first.preset != other.preset),
            ("settings", first.settings != other.settings),
            ("remarks on the set", first.remarks != other.remarks),
        ];
        if let Some((what, _)) = differs.into_iter().find(|(_, differs)| *differs) {
            let (one, other) = (named(first), named(other));
            let text = format!(
                "{one} and {other} are not of one ingest: {what} differs; ingest all parts alike"
            );
            return Err(parts_error(text));
        }
    }
    // A report without a part is that of a whole set: one of one.
    let of = first.part.map_or(1, |part| part.of());
    let numbers: Vec<usize> =
        parts.iter().map(|(_, report)| report.part.map_or(1, |part| part.number())).collect();
    if let Some(twice) = numbers.windows(2).find(|pair| pair[0] == pair[1]) {
        return Err(parts_error(format!("part {}/{of} is given twice", twice[0])));
    }
    if let Some(missing) = (1..=of).find(|number| !numbers.contains(number)) {
        let text = format!(
            "part {missing}/{of} is missing: make it by `ingest --part {missing}/{of}`, and name it too"
        );
        return Err(parts_error(text));
    }
    Ok(parts)
}

fn named(report: &IngestReport) -> String {
    report.part.map_or_else(|| "the whole set".to_owned(), |part| format!("part {part}"))
}

fn other_rows(part: &str, recording: &str) -> DatasetError {
    parts_error(format!(
        "the table of {part} is not that of its report: rows of {recording} differ in number or place; ingest \
         the part again"
    ))
}

fn parts_error(what: String) -> DatasetError {
    DatasetError::Parts { what }
}
