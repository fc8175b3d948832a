//! What bad input gets from a set's folder to its table: an error with path, place, value and
//! remedy, or a repair that is counted and named.

use std::{fs, path::Path};

use crate::made::{Made, manifest, write_set};
use dataset::{
    DatasetError, Exclusion, IngestSettings, ReadLimits, RecordingSet, RemarkKind, RepairKind,
    StreamRole, Streams, Table, ingest,
};

/// Writes a set of one push in CSV, or in JSON messages in MCAP, and spoils it.
fn spoiled(writer: &str, spoil: impl FnOnce(&Path)) -> (tempfile::TempDir, RecordingSet) {
    let dir = tempfile::tempdir().unwrap();
    write_set(dir.path(), writer, &[Made::default().recording("push")]);
    spoil(dir.path());
    let set = RecordingSet::open(dir.path()).unwrap();
    (dir, set)
}

/// Why the only recording of a set is of no use.
fn refusal(set: &RecordingSet) -> String {
    match ingest(set, &IngestSettings::default()) {
        Err(DatasetError::NothingUsable { recordings: 1, reason, .. }) => reason,
        other => panic!("{other:?}"),
    }
}

fn edit(path: &Path, change: impl FnOnce(&mut Vec<String>)) {
    let text = fs::read_to_string(path).unwrap();
    let mut lines: Vec<_> = text.lines().map(str::to_owned).collect();
    change(&mut lines);
    fs::write(path, lines.join("\n")).unwrap();
}

#[test]
fn a_missing_file_is_named() {
    let (_dir, set) = spoiled("csv", |dir| {
        fs::remove_file(dir.join("pushes/push/robot.csv")).unwrap();
    });
    let reason = refusal(&set);
    assert!(reason.contains("robot.csv"), "{reason}");
}

#[test]
fn a_file_that_is_no_text_is_named() {
    let (_dir, set) = spoiled("csv", |dir| {
        fs::write(dir.join("pushes/push/object.csv"), [0xff, 0xfe, 0x00, 0x80, b'\n']).unwrap();
    });
    let reason = refusal(&set);
    assert!(reason.contains("object.csv"), "{reason}");
}

#[test]
fn a_wrong_column_lists_those_that_are_there() {
    let (_dir, set) = spoiled("csv", |dir| {
        edit(&dir.join("pushes/push/object.csv"), |lines| lines[0] = "t_s,x_m,y_m,yaw".into());
    });
    let reason = refusal(&set);
    assert!(reason.contains("object.csv") && reason.contains("theta_rad"), "{reason}");
    assert!(reason.contains("yaw"), "{reason}");
}

#[test]
fn a_word_where_a_number_belongs_is_named_by_its_line() {
    let (_dir, set) = spoiled("csv", |dir| {
        edit(&dir.join("pushes/push/wrench.csv"), |lines| lines[7] = "1000.06,abc,1.0".into());
    });
    let (_, report) = match ingest(&set, &IngestSettings::default()) {
        Err(error) => {
            let message = error.to_string();
            assert!(message.contains("wrench.csv:8") && message.contains("abc"), "{message}");
            return;
        }
        Ok(done) => done,
    };
    assert!(report.to_text().contains("line 8"), "{}", report.to_text());
}

#[test]
fn stamps_that_run_back_or_come_twice_are_repaired_and_counted() {
    let (_dir, set) = spoiled("csv", |dir| {
        edit(&dir.join("pushes/push/object.csv"), |lines| {
            lines.swap(30, 31);
            lines.insert(60, lines[60].clone());
        });
    });
    let (_, report) = ingest(&set, &IngestSettings::default()).unwrap();
    let repairs = &report.summary.repairs[&StreamRole::Object];
    assert_eq!(repairs[&RepairKind::Backward], 1);
    assert_eq!(repairs[&RepairKind::Duplicate], 1);
}

#[test]
fn quaternions_far_from_unit_are_set_aside_and_counted() {
    // The quaternions of JSON messages lie uncompressed only in the source: make them by hand.
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("push.mcap");
    let mut writer = mcap::Writer::new(fs::File::create(&path).unwrap()).unwrap();
    let none = std::collections::BTreeMap::new();
    for topic in ["/tip", "/vicon/block"] {
        let channel = writer.add_channel(0, topic, "json", &none).unwrap();
        for i in 0..100_u64 {
            let w = if i == 40 { 0.5 } else { 1.0 };
            let message = format!(
                r#"{{"header":{{"stamp":{{"sec":7,"nanosec":{}}}}},"pose":{{"position":{{"x":0.1,
                "y":0,"z":0}},"orientation":{{"x":0,"y":0,"z":0,"w":{w}}}}}}}"#,
                i * 10_000_000
            );
            let time = 7_000_000_000 + i * 10_000_000;
            let header = mcap::records::MessageHeader {
                channel_id: channel,
                sequence: i as u32,
                log_time: time,
                publish_time: time,
            };
            writer.write_to_known_channel(&header, message.as_bytes()).unwrap();
        }
    }
    writer.finish().unwrap();
    let format = dataset::format_by_id("mcap").unwrap();
    let recording = format.read(&path, &Streams::default(), &ReadLimits::default()).unwrap();
    let remarks = recording.remarks.iter();
    let remark = remarks
        .clone()
        .find(|r| r.kind == RemarkKind::QuaternionExcluded && r.stream == Some(StreamRole::Object))
        .unwrap_or_else(|| panic!("{:?}", recording.remarks));
    assert_eq!(remark.count, 1);
    assert!(remark.text.contains("0.5"), "{}", remark.text);
    assert_eq!(recording.object.len(), 99);
}

#[test]
fn an_unknown_shape_and_a_degenerate_outline_are_refused_with_their_line() {
    let open = |from: &str, to: &str| {
        let dir = tempfile::tempdir().unwrap();
        let text = manifest("csv");
        assert!(text.contains(from));
        fs::write(dir.path().join("dataset.toml"), text.replacen(from, to, 1)).unwrap();
        RecordingSet::open(dir.path()).err().unwrap().to_string()
    };
    let message = open("\"square\"", "\"pentagram\"");
    assert!(message.contains("dataset.toml:4: object.shape = pentagram"), "{message}");
    assert!(message.contains("rect1") && message.contains("polygon"), "{message}");
    let outline = "shape = \"polygon\"\nvertices_m = [[0.0, 0.0], [0.1, 0.0], [0.2, 0.0]]";
    let message = open("shape = \"square\"\nside_m = 0.09", outline);
    assert!(message.contains("dataset.toml:5: object.vertices_m"), "{message}");
}

#[test]
fn a_topic_that_is_not_there_lists_those_that_are() {
    let (_dir, set) = spoiled("mcap-ros2", |dir| {
        let text = manifest("mcap") + "\n[streams.object]\ntopic = \"/vicon/hex\"\n";
        fs::write(dir.join("dataset.toml"), text).unwrap();
    });
    let reason = refusal(&set);
    assert!(reason.contains("no `/vicon/hex` for the object stream"), "{reason}");
    assert!(reason.contains("/vicon/object_pose (geometry_msgs/msg/PoseStamped)"), "{reason}");
}

#[test]
fn one_bad_recording_does_not_take_the_others_along() {
    let dir = tempfile::tempdir().unwrap();
    write_set(dir.path(), "csv", &["a", "b"].map(|name| Made::default().recording(name)));
    fs::write(dir.path().join("pushes/a/object.csv"), "").unwrap();
    let set = RecordingSet::open(dir.path()).unwrap();
    let (_, report) = ingest(&set, &IngestSettings::default()).unwrap();
    let Some(Exclusion::Unreadable { error }) = &report.recordings[0].excluded else {
        panic!("{:?}", report.recordings[0].excluded)
    };
    assert!(error.contains("object.csv"), "{error}");
    assert_eq!((report.summary.pushes_used, report.summary.excluded["unreadable"]), (1, 1));
}

#[test]
fn a_table_with_one_row_is_refused() {
    let (dir, set) = spoiled("csv", |_| {});
    let (mut table, _) = ingest(&set, &IngestSettings::default()).unwrap();
    table.rows.truncate(1);
    let path = dir.path().join("table.csv");
    table.write(&path).unwrap();
    let error = Table::read(&path).unwrap_err();
    assert!(matches!(error, DatasetError::TableTooShort { rows: 1, .. }));
    let message = error.to_string();
    assert!(
        message.contains("table.csv") && message.contains("at least 2 are needed"),
        "{message}"
    );
}
