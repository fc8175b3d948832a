//! Parts of a set, ingested apart and merged.

use std::path::Path;

use dataset::{
    DatasetError, IngestReport, IngestSettings, Part, RecordingSet, Table, ingest, merge_each,
};

fn set() -> RecordingSet {
    RecordingSet::open(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/pushes"))
        .unwrap()
}

/// Parts as files hold them: reports as text that is read again.
fn parts(of: usize) -> Vec<(Table, IngestReport)> {
    let part = |number| {
        let part = set().in_part(Part::new(number, of).unwrap());
        let (table, report) = ingest(&part, &IngestSettings::default()).unwrap();
        let text = serde_json::to_string(&report).unwrap();
        (table, serde_json::from_str(&text).unwrap())
    };
    (1..=of).map(part).collect()
}

fn merged(parts: &[(Table, IngestReport)]) -> Result<(Table, IngestReport), DatasetError> {
    let mut table = Table::default();
    let reports = parts.iter().map(|(_, report)| report.clone()).collect();
    let report = merge_each(
        reports,
        |index| Ok(parts[index].0.rows.clone()),
        |_, mut rows| {
            table.rows.append(&mut rows);
            Ok(())
        },
    )?;
    Ok((table, report))
}

#[test]
fn parts_in_any_order_and_number_merge_to_the_whole() {
    let (whole, report) = ingest(&set(), &IngestSettings::default()).unwrap();
    let n = set().recordings().len();
    // More parts than recordings, too: some are empty.
    for of in [1, 3, n + 2] {
        let mut parts = parts(of);
        parts.reverse();
        parts.swap(0, of / 2);
        let (table, merged) = merged(&parts).unwrap();
        assert!(table.rows == whole.rows, "{of}");
        assert_eq!(merged, report, "{of}");
    }
}

#[test]
fn parts_that_do_not_go_together_are_told() {
    let all = parts(3);
    let says = |parts: &[(Table, IngestReport)], text: &str| {
        let error = merged(parts).unwrap_err().to_string();
        assert!(error.contains(text), "{error}");
    };
    says(&[], "no part is given");
    says(&all[..2], "part 3/3 is missing: make it by `ingest --part 3/3`");
    says(&[all[0].clone(), all[0].clone(), all[2].clone()], "part 1/3 is given twice");
    let mut other = all.clone();
    other[1].1.settings.largest_tilt *= 2.0;
    says(&other, "part 1/3 and part 2/3 are not of one ingest: settings differs");
    let mut other = all.clone();
    other[2].1.part = Some(Part::new(4, 4).unwrap());
    says(&other, "the number of parts differs");
    let mut short = all.clone();
    short[1].0.rows.pop();
    says(&short, "the table of part 2/3 is not that of its report");
    let mut exchanged = all.clone();
    exchanged[1].0 = all[2].0.clone();
    says(&exchanged, "the table of part 2/3 is not that of its report");
    let mut long = all;
    let row = long[0].0.rows[0].clone();
    long[2].0.rows.push(row);
    says(&long, "the table of part 3/3 is not that of its report");
}
