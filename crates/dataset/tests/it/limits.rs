//! Recordings that ask for too much, or for what cannot be: each is refused by name, and the rest of
//! its set is read.

use std::{fs, path::Path};

use crate::made::{Made, write_set};
use allocation_counter::measure;
use dataset::{
    DatasetError, Exclusion, IngestReport, IngestSettings, LogFormat, PoseStream, ReadLimits,
    Recording, RecordingSet, RemarkKind, StepLength, Streams, Table, columns, format_by_id, ingest,
};

/// A set of two pushes, `bad` and `good`; the first is spoiled.
fn half_spoiled(
    writer: &str,
    bad: &Recording,
    spoil: impl FnOnce(&Path),
) -> (tempfile::TempDir, RecordingSet) {
    let dir = tempfile::tempdir().unwrap();
    write_set(dir.path(), writer, &[bad.clone(), Made::default().recording("good")]);
    spoil(dir.path());
    let set = RecordingSet::open(dir.path()).unwrap();
    (dir, set)
}

/// The reason for which the first recording of two was excluded; the other one gave rows.
fn reason(ingested: Result<(Table, IngestReport), DatasetError>) -> String {
    let (table, report) = ingested.unwrap();
    assert!(!table.is_empty() && table.rows.iter().all(|row| &*row.recording == "good"));
    match &report.recordings[0].excluded {
        Some(Exclusion::Unreadable { error }) => error.clone(),
        other => panic!("{other:?}"),
    }
}

fn add_limits(dir: &Path, limits: &str) {
    let path = dir.join("dataset.toml");
    let manifest = fs::read_to_string(&path).unwrap();
    fs::write(&path, format!("{manifest}\n[limits]\n{limits}\n")).unwrap();
}

#[test]
fn a_clock_that_jumps_from_1970_to_today_costs_its_recording_alone() {
    let mut bad = Made::default().recording("bad");
    // Before the object is seen at rest: it is shifted once more after the jump.
    let after = Made::default().stop() + 0.03;
    let shifted = bad.object.t.iter().map(|t| (after..after + 0.05).contains(t));
    for (x, _) in bad.object.x.iter_mut().zip(shifted).filter(|(_, shifted)| *shifted) {
        *x += 0.002;
    }
    const YEARS_56: f64 = 56.0 * 365.25 * 86400.0;
    for stream in [&mut bad.robot, &mut bad.object] {
        stream.t.iter_mut().filter(|t| **t > after).for_each(|t| *t += YEARS_56);
        assert!(stream.t.iter().any(|t| *t > 1e9));
    }
    for step in [StepLength::Time(0.2), StepLength::Time(0.01)] {
        let (_dir, set) = half_spoiled("csv", &bad, |_| {});
        let settings = IngestSettings { step, ..IngestSettings::default() };
        let reason = reason(ingest(&set, &settings));
        assert!(reason.contains("bad: at least ") && reason.contains(" steps up to "), "{reason}");
        assert!(reason.contains("does its clock jump?"), "{reason}");
        assert!(reason.ends_with("raise steps in [limits] of dataset.toml"), "{reason}");
    }
}

#[test]
fn the_limits_of_the_manifest_hold_for_every_format() {
    let bad = Made { duration: 3.0, ..Made::default() }.recording("bad");
    for writer in dataset::all_writers() {
        let id = writer.id();
        let (_dir, set) = half_spoiled(id, &bad, |dir| {
            add_limits(dir, &format!("samples = {}", bad.robot.len() - 1));
        });
        let reason = reason(ingest(&set, &IngestSettings::default()));
        assert!(reason.contains("raise samples in [limits] of dataset.toml"), "{id}: {reason}");
        let path = &set.recordings()[0];
        let limits = &set.manifest().limits;
        let error = set.format().read(path, &Streams::default(), limits).unwrap_err();
        assert!(matches!(error, DatasetError::OverLimit { .. }), "{id}: {error}");
    }
    let (_dir, set) = half_spoiled("csv", &bad, |dir| add_limits(dir, "steps = 10"));
    let reason = reason(ingest(&set, &IngestSettings::default()));
    assert!(reason.contains("more than the 10 allowed"), "{reason}");
}

#[test]
fn a_force_beyond_physics_is_set_aside_with_its_place() {
    let bad = Made::default().recording("bad");
    let (_dir, set) = half_spoiled("csv", &bad, |dir| {
        for (file, line, text) in
            [("wrench.csv", 60, "1000.58,1e308,-1e308"), ("object.csv", 40, "1000.38,1e200,0,0")]
        {
            let path = dir.join("pushes/bad").join(file);
            let text_before = fs::read_to_string(&path).unwrap();
            let mut lines: Vec<_> = text_before.lines().collect();
            lines[line - 1] = text;
            fs::write(&path, lines.join("\n")).unwrap();
        }
    });
    let (table, report) = ingest(&set, &IngestSettings::default()).unwrap();
    let remarks = &report.recordings[0].remarks;
    assert_eq!(report.recordings[0].excluded, None);
    let kinds: Vec<_> = remarks.iter().map(|remark| (remark.kind, remark.count)).collect();
    assert_eq!(kinds, [(RemarkKind::OutOfRangeExcluded, 1); 2]);
    assert!(remarks[1].text.contains("1e308 is beyond ±1e9 in SI units, first at line 60"));
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("table.csv");
    table.write(&path).unwrap();
    assert_eq!(Table::read(&path).unwrap().len(), table.len());
    assert!(columns().len() > 40 && table.rows.iter().all(|row| row.force.is_some()));
}

/// A format of a user's own that panics on one of its files, and hands over what cannot be.
struct Careless;

impl LogFormat for Careless {
    fn id(&self) -> &'static str {
        "careless"
    }

    fn endings(&self) -> &'static [&'static str] {
        &["log"]
    }

    fn read(&self, path: &Path, _: &Streams, _: &ReadLimits) -> Result<Recording, DatasetError> {
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        let Recording { robot, object, wrench, .. } = Made::default().recording("x");
        match name.as_str() {
            "a" => panic!("no such sensor: {}", 7),
            "b" => {
                let robot = PoseStream { t: vec![1e300; robot.len()], ..robot };
                let object = PoseStream { x: vec![-1e300; object.len()], ..object };
                Ok(Recording::made(name, 0, robot, object, wrench))
            }
            _ => Ok(Recording::made(name, 0, robot, object, wrench)),
        }
    }
}

#[test]
fn a_panic_in_a_format_of_ones_own_sets_its_recording_aside() {
    let dir = tempfile::tempdir().unwrap();
    fs::create_dir(dir.path().join("pushes")).unwrap();
    for name in ["a", "b", "c"] {
        fs::write(dir.path().join(format!("pushes/{name}.log")), "").unwrap();
    }
    let manifest = crate::made::manifest("x").replace("format = \"x\"\n", "");
    fs::write(dir.path().join("dataset.toml"), manifest).unwrap();
    let set = RecordingSet::open_with_format(dir.path(), &Careless).unwrap();
    let (table, report) = ingest(&set, &IngestSettings::default()).unwrap();
    assert!(!table.is_empty() && table.rows.iter().all(|row| &*row.recording == "c"));
    let Some(Exclusion::Unreadable { error }) = &report.recordings[0].excluded else {
        panic!("{:?}", report.recordings[0].excluded)
    };
    assert!(error.contains("a.log: the reader failed on this file"), "{error}");
    assert!(error.ends_with("no such sensor: 7"), "{error}");
    assert_eq!(report.recordings[1].excluded, Some(Exclusion::NoOverlap));
}

#[cfg(unix)]
#[test]
fn a_pipe_or_a_device_in_a_recordings_place_is_refused() {
    let bad = Made::default().recording("bad");
    let (dir, set) = half_spoiled("csv", &bad, |dir| {
        let wrench = dir.join("pushes/bad/wrench.csv");
        fs::remove_file(&wrench).unwrap();
        assert!(std::process::Command::new("mkfifo").arg(&wrench).status().unwrap().success());
    });
    let reason = reason(ingest(&set, &IngestSettings::default()));
    assert!(reason.ends_with("wrench.csv: this is a pipe; give a regular file"), "{reason}");
    let pipe = dir.path().join("pushes/bad/wrench.csv");
    for (path, kind) in [(pipe.as_path(), "pipe"), (Path::new("/dev/zero"), "device")] {
        let error = RecordingSet::open(path).err().unwrap();
        assert!(matches!(&error, DatasetError::NotAFile { kind: k, .. } if *k == kind), "{error}");
        for format in dataset::all_formats().iter().filter(|format| format.id() != "csv") {
            let error = format.read(path, &Streams::default(), &ReadLimits::default());
            assert!(matches!(error, Err(DatasetError::NotAFile { .. })), "{}", format.id());
            let error = format.inspect(path, &ReadLimits::default());
            assert!(matches!(error, Err(DatasetError::NotAFile { .. })), "{}", format.id());
        }
    }
}

fn mcap_record(opcode: u8, parts: &[&[u8]]) -> Vec<u8> {
    let body = parts.concat();
    [&[opcode][..], &(body.len() as u64).to_le_bytes(), &body].concat()
}

/// Files of some hundred bytes that claim gigabytes, each in another place.
fn small_liars() -> Vec<Vec<u8>> {
    const HUGE: [u8; 4] = (u32::MAX - 7).to_le_bytes();
    let huge = (u64::from(u32::MAX) - 7).to_le_bytes();
    let magic = b"\x89MCAP0\r\n";
    let text = |text: &str| [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat();
    let times = [0; 16];
    let packed = zstd::encode_all(&[0; 100][..], 1).unwrap();
    let length = (packed.len() as u64).to_le_bytes();
    let records = [
        mcap_record(6, &[&times, &huge, &[0; 4], &text("zstd"), &length, &packed]),
        mcap_record(6, &[&times, &huge, &[0; 4], &text("lz4"), &length, &packed]),
        mcap_record(6, &[&times, &huge, &[0; 4], &text(""), &huge, &packed]),
        mcap_record(3, &[&[1, 0], &HUGE, b"name"]),
        mcap_record(4, &[&[1, 0, 1, 0], &text("/tip"), &HUGE, b"ros1"]),
        mcap_record(8, &[&[0; 32], &HUGE, &[0; 50]]),
        mcap_record(11, &[&[0; 42], &HUGE, &[0; 50]]),
    ];
    let whole = |record: &Vec<u8>| {
        let data_end = mcap_record(15, &[&[0; 4]]);
        let summary = [&magic[..], record, &data_end].concat().len() as u64;
        let footer = mcap_record(2, &[&summary.to_le_bytes(), &[0; 12]]);
        [&magic[..], record, &data_end, record, &footer, magic].concat()
    };
    records.iter().map(whole).collect()
}

#[test]
fn a_small_file_reserves_no_memory_by_what_it_claims() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("log.mcap");
    let format = format_by_id("mcap").unwrap();
    for bytes in small_liars() {
        assert!(bytes.len() < 400);
        fs::write(&path, &bytes).unwrap();
        let info = measure(|| {
            let read = format.read(&path, &Streams::default(), &ReadLimits::default());
            assert!(matches!(read, Err(DatasetError::Damaged { .. })), "{read:?}");
        });
        // A count for each of the 65536 possible channels is the largest part.
        assert!(info.bytes_max < 2_000_000, "{}", info.bytes_max);
    }
}

/// A recording whose chunks unpack to a gigabyte of zeros after its whole part.
#[test]
fn a_bomb_is_refused_and_the_rest_of_the_set_is_read() {
    let bad = Made::default().recording("bad");
    let (_dir, set) = half_spoiled("mcap-ros2", &bad, |dir| {
        let path = dir.join("pushes/bad.mcap");
        let whole = fs::read(&path).unwrap();
        let zeros = vec![0; 1 << 22];
        let packed = zstd::encode_all(&zeros[..], 1).unwrap();
        let packed = packed.repeat(64);
        let size = (64 * zeros.len() as u64).to_le_bytes();
        let length = (packed.len() as u64).to_le_bytes();
        let name = [4, 0, 0, 0, b'z', b's', b't', b'd'];
        let chunk = mcap_record(6, &[&[0; 16], &size, &[0; 4], &name, &length, &packed]);
        assert!(chunk.len() < 100_000);
        fs::write(&path, [&whole[..8], &chunk, &whole[8..]].concat()).unwrap();
        add_limits(dir, "chunk_bytes = 10_000_000");
    });
    let mut reason_told = String::new();
    let path = set.recordings()[0].clone();
    let info = measure(|| {
        let error = set.read(&path).unwrap_err();
        reason_told = error.to_string();
    });
    assert!(reason_told.contains("raise chunk_bytes in [limits]"), "{reason_told}");
    assert!(info.bytes_max < 60_000_000, "{}", info.bytes_max);
    assert_eq!(reason(ingest(&set, &IngestSettings::default())), reason_told);
}

/// Statistics may leave out how many messages each channel has.
#[test]
fn statistics_without_counts_by_channel_do_not_hide_the_topics() {
    let made = Made::default().recording("bad");
    let (_dir, set) = half_spoiled("mcap-ros2", &made, |dir| {
        let path = dir.join("pushes/bad.mcap");
        let mut bytes = fs::read(&path).unwrap();
        // The statistics keep their 42 fixed bytes, then the length of the counts and the counts.
        let footer = bytes.len() - 37;
        let mut at =
            u64::from_le_bytes(bytes[footer + 9..footer + 17].try_into().unwrap()) as usize;
        while bytes[at] != 11 {
            at += 9 + u64::from_le_bytes(bytes[at + 1..at + 9].try_into().unwrap()) as usize;
        }
        let counts = at + 9 + 42;
        assert_eq!(bytes[counts..counts + 4], [30, 0, 0, 0]);
        bytes[counts..counts + 4].fill(0);
        fs::write(&path, bytes).unwrap();
    });
    let (table, report) = ingest(&set, &IngestSettings::default()).unwrap();
    assert_eq!(report.recordings[0].excluded, None);
    assert!(table.rows.iter().any(|row| &*row.recording == "bad"));
}
