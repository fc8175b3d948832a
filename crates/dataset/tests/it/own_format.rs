//! A log format of a user's own, as the example and its page have it.

#[path = "../../examples/own_log_format.rs"]
mod own_log_format;

use dataset::{DatasetError, Limit, LogFormat, ReadLimits, RecordingSet, StreamRole, Streams};
use own_log_format::TextLog;

const PAGE: &str = include_str!("../../../../docs/write-your-own-log-format.md");
const EXAMPLE: &str = include_str!("../../examples/own_log_format.rs");

#[test]
fn the_example_reads_its_logs_to_the_table_of_the_fixtures() {
    own_log_format::main().unwrap();
}

#[test]
fn the_page_shows_the_reader_of_the_example_in_at_most_forty_lines() {
    let reader = |text: &'static str| {
        let from = text.find("impl LogFormat for TextLog").unwrap();
        text[from..].split("\n}\n").next().unwrap()
    };
    assert_eq!(reader(PAGE), reader(EXAMPLE));
    assert!(reader(PAGE).lines().count() < 40);
}

#[test]
fn a_wrong_line_is_named_and_a_recording_tells_what_it_has() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.log");
    std::fs::write(&path, "tip 1 2 3\ntip 2 2 3\nobject 1 2 3 4\n").unwrap();
    let limits = ReadLimits::default();
    let seen = TextLog.inspect(&path, &limits).unwrap();
    let streams: Vec<_> = seen.streams.iter().map(|s| (s.count, s.rate_hz, s.fits[0])).collect();
    assert_eq!(streams[..2], [(2, Some(1.0), StreamRole::Robot), (1, None, StreamRole::Object),]);
    assert_eq!(TextLog.read(&path, &Streams::default(), &limits).unwrap().sha256.len(), 64);
    std::fs::write(&path, "tip 1 2 3\ntip 1 2\n").unwrap();
    let error = TextLog.read(&path, &Streams::default(), &limits).unwrap_err();
    assert!(error.to_string().ends_with("a.log:2: tip 1 2"), "{error}");
    let limits = limits.with(Limit::Samples, 1);
    let error = TextLog.read(&path, &Streams::default(), &limits).unwrap_err();
    assert!(matches!(error, DatasetError::OverLimit { needed: 2, limit: 1, .. }), "{error}");
}

#[test]
fn a_manifest_that_names_another_format_is_refused() {
    let fixtures = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/pushes");
    let error = RecordingSet::open_with_format(fixtures.as_ref(), &TextLog).err().unwrap();
    assert!(matches!(&error, DatasetError::UnknownFormat { id, .. } if id == "csv"), "{error}");
}
