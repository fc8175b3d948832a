//! What would be read wrongly without a word: mixed pushes, lost rows, wrong times, mixed messages.

use std::{collections::BTreeMap, fs, path::Path};

use crate::made::{Made, manifest, write_set};
use dataset::{
    DatasetError, IngestSettings, LogFormat, ReadLimits, Recording, RecordingSet, RemarkKind,
    Streams, ingest,
};

/// A set with these recordings, written by one writer.
fn set_of(writer: &str, names: &[&str]) -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    let recordings: Vec<_> = names.iter().map(|name| Made::default().recording(name)).collect();
    write_set(dir.path(), writer, &recordings);
    dir
}

/// The remarks of one kind: how many things each counts, and what it says.
fn remarks(dir: &Path, kind: RemarkKind) -> Vec<(u64, String)> {
    let set = RecordingSet::open(dir).unwrap();
    let (_, report) = ingest(&set, &IngestSettings::default()).unwrap();
    let own = report.remarks.into_iter().filter(|remark| remark.kind == kind);
    own.map(|remark| (remark.count, remark.text)).collect()
}

#[test]
fn names_that_differ_after_a_dot_are_those_of_two_recordings() {
    for writer in ["csv", "mcap-ros2"] {
        let dir = set_of(writer, &["angle-0.1", "angle-0.2"]);
        let set = RecordingSet::open(dir.path()).unwrap();
        let (table, report) = ingest(&set, &IngestSettings::default()).unwrap();
        let names: Vec<_> = report.recordings.iter().map(|one| one.name.as_str()).collect();
        assert_eq!(names, ["angle-0.1", "angle-0.2"], "{writer}");
        for name in names {
            assert!(table.rows.iter().any(|row| &*row.recording == name), "{writer}: {name}");
        }
    }
}

/// Logs with two endings, of which this test needs the names alone.
struct TwoEndings;

impl LogFormat for TwoEndings {
    fn id(&self) -> &'static str {
        "two-endings"
    }

    fn endings(&self) -> &'static [&'static str] {
        &["log", "txt"]
    }

    fn read(&self, _: &Path, _: &Streams, _: &ReadLimits) -> Result<Recording, DatasetError> {
        unreachable!("the names are refused first")
    }
}

#[test]
fn two_recordings_of_one_name_are_refused_with_both_paths() {
    let dir = tempfile::tempdir().unwrap();
    fs::create_dir(dir.path().join("pushes")).unwrap();
    fs::write(dir.path().join("dataset.toml"), manifest("").replace("format = \"\"\n", ""))
        .unwrap();
    for file in ["push-1.log", "push-2.log", "push-1.txt"] {
        fs::write(dir.path().join("pushes").join(file), "").unwrap();
    }
    let error = RecordingSet::open_with_format(dir.path(), &TwoEndings).err().unwrap();
    let message = error.to_string();
    assert!(matches!(error, DatasetError::DuplicateRecording { .. }), "{message}");
    assert!(message.contains("`push-1`"), "{message}");
    assert!(message.contains("push-1.log") && message.contains("push-1.txt"), "{message}");
}

#[test]
fn rows_of_sessions_that_match_nothing_are_counted_and_named() {
    let dir = set_of("csv", &["angle-0.1", "angle-0.2"]);
    let path = dir.path().join("sessions.csv");
    fs::write(&path, "recording,session,repeat\nangle-0.1,monday,\nangle-0,monday,\n").unwrap();
    let [(1, unknown)] = &remarks(dir.path(), RemarkKind::SessionUnknown)[..] else { panic!() };
    assert!(unknown.starts_with("1 of 2 rows of ") && unknown.ends_with("(angle-0)"), "{unknown}");
    let [(1, missing)] = &remarks(dir.path(), RemarkKind::SessionMissing)[..] else { panic!() };
    assert!(missing.starts_with("1 of 2 recordings"), "{missing}");
    assert!(missing.ends_with("(angle-0.2)"), "{missing}");
    fs::write(&path, "recording,session,repeat\nangle-0.1.csv,monday,\n").unwrap();
    let error = RecordingSet::open(dir.path()).err().unwrap();
    assert!(matches!(error, DatasetError::SessionsOfOthers { rows: 1, .. }), "{error}");
}

#[test]
fn recordings_of_another_format_in_the_folder_are_counted_and_named() {
    let dir = set_of("mcap-ros2", &["a", "b"]);
    assert_eq!(remarks(dir.path(), RemarkKind::NotRead), []);
    for file in ["c.bag", "d.bag", "e.bag"] {
        fs::write(dir.path().join("pushes").join(file), "#ROSBAG V2.0\n").unwrap();
    }
    let [(3, text)] = &remarks(dir.path(), RemarkKind::NotRead)[..] else { panic!() };
    assert!(text.starts_with("3 recordings of format ros1-bag in "), "{text}");
    assert!(text.ends_with("(c.bag, d.bag, e.bag)"), "{text}");
}

#[test]
fn times_since_1970_in_another_unit_are_refused_by_its_name() {
    for (unit, per_second, scale) in
        [("milliseconds", 1e3, "1e-3"), ("microseconds", 1e6, "1e-6"), ("nanoseconds", 1e9, "1e-9")]
    {
        let dir = set_of("csv", &["push"]);
        let path = dir.path().join("pushes/push/robot.csv");
        let text = fs::read_to_string(&path).unwrap();
        let (header, rows) = text.split_once('\n').unwrap();
        let changed = rows.lines().map(|row| {
            let (time, rest) = row.split_once(',').unwrap();
            let time = per_second * (1.7e9 + time.parse::<f64>().unwrap());
            format!("{time},{rest}\n")
        });
        fs::write(&path, format!("{header}\n{}", changed.collect::<String>())).unwrap();
        let set = RecordingSet::open(dir.path()).unwrap();
        let message = set.read(&set.recordings()[0]).unwrap_err().to_string();
        assert!(message.contains("robot.csv:2: column t_s: "), "{message}");
        assert!(message.contains(&format!("perhaps in {unit}: set t with scale = {scale}")));
    }
}

/// A log of JSON messages: the channels' topics with the names of their schemas.
fn write_log(path: &Path, channels: &[(&str, &str)]) {
    let mut writer = mcap::Writer::new(fs::File::create(path).unwrap()).unwrap();
    for (topic, type_name) in channels {
        let schema = writer.add_schema(type_name, "", &[]).unwrap();
        let channel = writer.add_channel(schema, topic, "json", &BTreeMap::new()).unwrap();
        for i in 0..100_u32 {
            let time = 7_000_000_000 + u64::from(i) * 10_000_000;
            let message = format!(
                r#"{{"header":{{"stamp":{{"sec":7,"nanosec":{}}}}},"pose":{{"position":{{"x":0.1,
                "y":0,"z":0}},"orientation":{{"x":0,"y":0,"z":0,"w":1}}}}}}"#,
                i * 10_000_000
            );
            let header = mcap::records::MessageHeader {
                channel_id: channel,
                sequence: i,
                log_time: time,
                publish_time: time,
            };
            writer.write_to_known_channel(&header, message.as_bytes()).unwrap();
        }
    }
    writer.finish().unwrap();
}

#[test]
fn a_topic_of_two_types_is_refused_with_both() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("push.mcap");
    let read = || {
        let format = dataset::format_by_id("mcap").unwrap();
        format.read(&path, &Streams::default(), &ReadLimits::default())
    };
    // Several publishers of one type are one stream, also under the names of ROS 1 and ROS 2.
    let tip = ("/tip", "geometry_msgs/msg/PoseStamped");
    let block = ("/vicon/block", "geometry_msgs/msg/PoseStamped");
    write_log(&path, &[tip, block, ("/vicon/block", "geometry_msgs/PoseStamped")]);
    read().unwrap();
    write_log(&path, &[tip, block, ("/vicon/block", "rig_msgs/msg/Setpoint")]);
    let error = read().unwrap_err();
    assert!(matches!(error, DatasetError::TopicTypes { .. }), "{error}");
    let message = error.to_string();
    let both = "types, geometry_msgs/PoseStamped and rig_msgs/Setpoint, ";
    assert!(message.contains("/vicon/block") && message.contains(both), "{message}");
}

#[test]
fn a_manifest_that_renames_the_files_of_a_folder_reads_them() {
    let dir = set_of("csv", &["a", "b"]);
    let read = || ingest(&RecordingSet::open(dir.path()).unwrap(), &IngestSettings::default());
    let (usual, _) = read().unwrap();
    for push in ["a", "b"].map(|name| dir.path().join("pushes").join(name)) {
        for (from, to) in [("robot", "tip"), ("object", "block"), ("wrench", "cell")] {
            fs::rename(push.join(format!("{from}.csv")), push.join(format!("{to}.csv"))).unwrap();
        }
    }
    for ending in [".csv", ""] {
        let streams = [("robot", "tip"), ("object", "block"), ("wrench", "cell")]
            .map(|(stream, file)| format!("\n[streams.{stream}]\ntopic = \"{file}{ending}\"\n"));
        let text = manifest("csv") + &streams.concat();
        fs::write(dir.path().join("dataset.toml"), text).unwrap();
        let (renamed, _) = read().unwrap();
        assert_eq!(renamed.rows, usual.rows, "{ending}");
    }
}
