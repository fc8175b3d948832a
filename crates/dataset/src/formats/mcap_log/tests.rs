//! MCAP files made here, whole and damaged in every way that was met.

use std::{collections::BTreeMap, fs, io::Cursor, path::PathBuf};

use mcap::{
    Compression, Summary, WriteOptions,
    records::{MessageHeader, op},
};
use proptest::prelude::{ProptestConfig, any, prop_assert, proptest};
use tempfile::TempDir;

use super::McapFormat;
use crate::formats::format::LogFormat;
use crate::formats::mcap_record::{PREFIX, record_at};
use crate::input::limits::{Limit, ReadLimits};
use crate::recording::Recording;
use crate::recording::settings::{Streams, TimeSource};
use crate::{
    error::DatasetError,
    remark::{RemarkKind, StreamRole},
};

const SCHEMA: &[u8] = b"time stamp\nfloat64 x\nfloat64 y\nfloat64 theta\n";
const N: u32 = 200;

/// Poses on `/tip` and `/block` and noise on `/other`, stamped from 5 s on every 10 ms.
fn file_with(options: WriteOptions, stamped: impl Fn(u32) -> bool) -> Vec<u8> {
    let mut writer = options.create(Cursor::new(Vec::new())).unwrap();
    let schema = writer.add_schema("my_msgs/Pose", "ros1msg", SCHEMA).unwrap();
    let none = BTreeMap::new();
    let other = writer.add_schema("std_msgs/String", "ros1msg", b"string data").unwrap();
    let channels = [
        writer.add_channel(schema, "/tip", "ros1", &none).unwrap(),
        writer.add_channel(schema, "/block", "ros1", &none).unwrap(),
        writer.add_channel(other, "/other", "ros1", &none).unwrap(),
    ];
    for i in 0..N {
        let log_time = 5_000_000_000 + 10_000_000 * u64::from(i);
        for (k, channel_id) in channels.into_iter().enumerate() {
            let (sec, nsec) = if stamped(i) { (5 + i / 100, i % 100 * 10_000_000) } else { (0, 0) };
            let mut data = Vec::new();
            if k < 2 {
                data.extend(sec.to_le_bytes());
                data.extend(nsec.to_le_bytes());
                for value in [f64::from(i), k as f64, 0.5] {
                    data.extend(value.to_le_bytes());
                }
            } else {
                data.extend([3, 0, 0, 0, b'a', b'b', b'c']);
            }
            let publish_time = log_time + 1_000;
            let log_time = log_time + 1_000;
            let header = MessageHeader { channel_id, sequence: i, log_time, publish_time };
            writer.write_to_known_channel(&header, &data).unwrap();
        }
    }
    writer.finish().unwrap();
    writer.into_inner().into_inner()
}

fn options() -> WriteOptions {
    WriteOptions::new().chunk_size(Some(2048)).compression(None)
}

fn file() -> Vec<u8> {
    file_with(options(), |_| true)
}

fn saved(bytes: &[u8]) -> (TempDir, PathBuf) {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("log.mcap");
    fs::write(&path, bytes).unwrap();
    (dir, path)
}

fn read_with(bytes: &[u8], streams: &Streams) -> Result<Recording, DatasetError> {
    let (_dir, path) = saved(bytes);
    McapFormat.read(&path, streams, &ReadLimits::default())
}

fn read(bytes: &[u8]) -> Result<Recording, DatasetError> {
    read_with(bytes, &Streams::default())
}

fn kinds(recording: &Recording) -> Vec<RemarkKind> {
    recording.remarks.iter().map(|remark| remark.kind).collect()
}

#[test]
fn every_compression_gives_the_same_recording() {
    let plain = read(&file()).unwrap();
    assert_eq!(plain.robot.len(), N as usize);
    assert_eq!(plain.robot.source, "/tip");
    assert_eq!(plain.object.y, vec![1.0; N as usize]);
    assert_eq!((plain.epoch_ns, plain.robot.t[123]), (5_000_000_000, 1.23));
    assert_eq!(plain.wrench, None);
    assert_eq!(plain.remarks, []);
    for options in [
        options().compression(Some(Compression::Zstd)),
        options().compression(Some(Compression::Lz4)),
        options().use_chunks(false),
    ] {
        let other = read(&file_with(options, |_| true)).unwrap();
        assert_eq!((other.robot, other.object), (plain.robot.clone(), plain.object.clone()));
        assert_eq!(other.remarks, []);
    }
}

/// The chunks of a file in another order, each of which then overlaps others in time.
fn shuffled(bytes: &[u8]) -> Vec<u8> {
    let (mut chunks, mut at) = (Vec::new(), mcap::MAGIC.len());
    while let Some((opcode, body)) = record_at(bytes, at)
        && opcode != op::DATA_END
    {
        let end = at + PREFIX + body.len();
        chunks.extend((opcode == op::CHUNK).then(|| &bytes[at..end]));
        at = end;
    }
    let (even, odd): (Vec<_>, Vec<_>) = (0..chunks.len()).partition(|k| k % 2 == 0);
    let order = odd.iter().rev().chain(&even);
    let records: Vec<u8> = order.flat_map(|k| chunks[*k].iter().copied()).collect();
    [mcap::MAGIC, &records].concat()
}

#[test]
fn chunks_that_threads_share_give_the_recording_of_one_thread() {
    let with = |n: usize, bytes: &[u8], limits: &ReadLimits| {
        let (_dir, path) = saved(bytes);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        let read = pool.install(|| McapFormat.read(&path, &Streams::default(), limits));
        // The file is in another folder each time.
        let name = path.display().to_string();
        format!("{read:?}").replace(&name, "log").replace(path.to_str().unwrap(), "log")
    };
    let zstd = file_with(options().compression(Some(Compression::Zstd)), |_| true);
    let mut damaged = shuffled(&zstd);
    // Within the data of the chunk that stands last.
    let place = damaged.len() - 20;
    damaged[place] ^= 0x55;
    let tight = ReadLimits::default().with(Limit::UnpackedBytes, 9000);
    for (bytes, limits, says) in [
        (&zstd, &ReadLimits::default(), "robot: PoseStream"),
        (&shuffled(&zstd), &ReadLimits::default(), "NoIndex"),
        (&shuffled(&file()), &ReadLimits::default(), "NoIndex"),
        (&damaged, &ReadLimits::default(), "ChunkSkipped"),
        (&zstd, &tight, "OverLimit"),
    ] {
        let one = with(1, bytes, limits);
        assert!(one.contains(says), "{one}");
        for n in [2, 8] {
            assert!(with(n, bytes, limits) == one, "{n} threads: {says}");
        }
    }
}

#[test]
fn a_missing_stamp_falls_back_to_the_log_time() {
    let bytes = file_with(options(), |i| i >= 5);
    let recording = read(&bytes).unwrap();
    assert_eq!(kinds(&recording), [RemarkKind::LogTimeUsed; 2]);
    let remark = &recording.remarks[0];
    assert_eq!((remark.count, remark.stream), (5, Some(StreamRole::Robot)));
    assert_eq!(
        remark.text,
        "5 of 200 messages of /tip have no stamp of their own; the log time is used"
    );
    assert_eq!(recording.robot.t[..2], [1e-6, 0.010_001]);
    assert_eq!(recording.robot.t[5], 0.05);
    let mut streams = Streams::default();
    streams.robot.time = TimeSource::Log;
    streams.object.time = TimeSource::Log;
    let recording = read_with(&bytes, &streams).unwrap();
    assert_eq!(recording.remarks, []);
    assert_eq!(recording.robot.t[5], 0.050_001);
}

#[test]
fn a_file_without_check_sums_says_so() {
    let recording = read(&file_with(options().calculate_chunk_crcs(false), |_| true)).unwrap();
    assert_eq!(kinds(&recording), [RemarkKind::NoChecksums]);
    assert!(recording.remarks[0].text.contains("no check sums"));
}

#[test]
fn a_file_without_an_index_is_scanned() {
    let bare = options()
        .emit_summary_records(false)
        .emit_chunk_indexes(false)
        .repeat_channels(false)
        .repeat_schemas(false);
    let recording = read(&file_with(bare, |_| true)).unwrap();
    assert_eq!(kinds(&recording), [RemarkKind::NoIndex]);
    assert_eq!(recording.robot, read(&file()).unwrap().robot);
}

#[test]
fn a_flipped_bit_costs_its_chunk_alone() {
    let mut bytes = file();
    let summary = Summary::read(&bytes).unwrap().unwrap();
    let chunk = &summary.chunk_indexes[2];
    let start = chunk.chunk_start_offset as usize;
    bytes[start + chunk.chunk_length as usize - 20] ^= 4;
    let recording = read(&bytes).unwrap();
    assert_eq!(kinds(&recording), [RemarkKind::ChunkSkipped]);
    let remark = &recording.remarks[0];
    let kept = recording.robot.len() + recording.object.len();
    assert_eq!(remark.count as usize, 2 * N as usize - kept);
    assert!(remark.count > 10);
    let begin = format!("the chunk at byte {start}: its check sum is ");
    assert!(remark.text.starts_with(&begin), "{}", remark.text);
    assert!(remark.text.ends_with(&format!("; {} wanted messages are lost", remark.count)));
}

#[test]
fn a_wrong_record_length_is_overcome_by_the_index() {
    let mut bytes = file();
    let summary = Summary::read(&bytes).unwrap().unwrap();
    let start = summary.chunk_indexes[1].chunk_start_offset as usize;
    let next = summary.chunk_indexes[2].chunk_start_offset;
    bytes[start + 1..start + 9].copy_from_slice(&u64::MAX.to_le_bytes());
    let recording = read(&bytes).unwrap();
    assert_eq!(kinds(&recording), [RemarkKind::ChunkSkipped]);
    let begin = format!("bytes {start} to {next} hold no valid record");
    assert!(recording.remarks[0].text.starts_with(&begin), "{}", recording.remarks[0].text);
    assert!(recording.robot.len() > N as usize * 3 / 4 && recording.robot.len() < N as usize);
}

#[test]
fn a_truncated_file_yields_what_is_whole() {
    let bytes = file();
    let summary = Summary::read(&bytes).unwrap().unwrap();
    let cut = summary.chunk_indexes[3].chunk_start_offset as usize + 100;
    let recording = read(&bytes[..cut]).unwrap();
    assert_eq!(kinds(&recording), [RemarkKind::NoIndex, RemarkKind::Truncated]);
    let whole = read(&bytes).unwrap();
    let n = recording.robot.len();
    assert!(n > 10);
    assert_eq!(recording.robot.x, whole.robot.x[..n]);
    let text = &recording.remarks[1].text;
    let end = format!("the file ends at byte {cut}, in the middle of what begins at byte ");
    assert!(text.starts_with(&end), "{text}");
}

#[test]
fn a_file_without_anything_to_read_is_an_error_with_its_byte() {
    let bytes = file();
    let cases: [(&[u8], u64, &str); 4] = [
        (b"", 0, "the file is empty; record it again"),
        (b"#ROSBAG V2.0\n", 0, "no MCAP file: it does not begin with \\x89MCAP0; check `format`"),
        (&bytes[1..], 0, "no MCAP file"),
        (&bytes[..60], 60, "the file holds no channel that can be read"),
    ];
    for (bytes, at, what) in cases {
        let error = read(bytes).unwrap_err();
        assert!(matches!(error, DatasetError::Damaged { byte, .. } if byte == at), "{error}");
        let message = error.to_string();
        assert!(message.contains(&format!("log.mcap: byte {at}: {what}")), "{message}");
    }
    let error = McapFormat
        .read("nowhere.mcap".as_ref(), &Streams::default(), &ReadLimits::default())
        .unwrap_err();
    assert!(matches!(error, DatasetError::Io { action: "read", .. }), "{error}");
    assert!(error.to_string().starts_with("cannot read nowhere.mcap: "), "{error}");
}

#[test]
fn an_empty_folder_is_an_error() {
    let dir = tempfile::tempdir().unwrap();
    let error = McapFormat.find(dir.path()).unwrap_err();
    assert!(matches!(error, DatasetError::NoRecordings { format: "mcap", .. }));
    assert!(error.to_string().contains("expected files NAME.mcap"), "{error}");
}

#[test]
fn an_unusable_topic_is_an_error_with_its_remedy() {
    let mut streams = Streams::default();
    streams.object.topic = Some("/other".into());
    let error = read_with(&file(), &streams).unwrap_err();
    assert!(matches!(error, DatasetError::FieldMissing { stream: StreamRole::Object, .. }));
    let message = error.to_string();
    assert!(message.contains("topic /other of type std_msgs/String"), "{message}");
    assert!(message.contains("set streams.object.fields"), "{message}");
}

#[test]
fn an_inspection_lists_topics_rates_and_uses() {
    let (_dir, path) = saved(&file());
    let inspection = McapFormat.inspect(&path, &ReadLimits::default()).unwrap();
    let names: Vec<_> = inspection.streams.iter().map(|s| (s.name.as_str(), s.count)).collect();
    assert_eq!(names, [("/tip", 200), ("/block", 200), ("/other", 200)]);
    assert_eq!(inspection.streams[0].fits, [StreamRole::Robot, StreamRole::Object]);
    assert_eq!(inspection.streams[2].fits, []);
    assert!((inspection.streams[0].rate_hz.unwrap() - 100.0).abs() < 1e-9);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn damage_anywhere_never_panics_nor_makes_up_samples(
        at in any::<proptest::sample::Index>(), byte in any::<u8>(), cut in any::<bool>()
    ) {
        let mut bytes = file();
        let at = at.index(bytes.len());
        if cut {
            bytes.truncate(at);
        } else {
            bytes[at] = byte;
        }
        if let Ok(recording) = read(&bytes) {
            prop_assert!(recording.robot.len() <= N as usize);
            prop_assert!(recording.robot.x.iter().all(|x| x.fract() == 0.0 && *x < f64::from(N)));
        }
    }
}
