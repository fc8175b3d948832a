//! Bags made here, whole and damaged.

use std::{fs, io::Write as _};

use proptest::prelude::{any, prop_assert, proptest};

use super::{BagFormat, op};
use crate::formats::format::LogFormat;
use crate::input::limits::ReadLimits;
use crate::recording::Recording;
use crate::recording::settings::Streams;
use crate::{error::DatasetError, remark::RemarkKind};

const N: u32 = 60;
const PER_CHUNK: u32 = 20;
const TOPICS: [&str; 2] = ["/tip", "/block"];

fn fields(pairs: &[(&str, &[u8])]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for (name, value) in pairs {
        bytes.extend(((name.len() + 1 + value.len()) as u32).to_le_bytes());
        bytes.extend(name.as_bytes());
        bytes.push(b'=');
        bytes.extend(*value);
    }
    bytes
}

fn record(header: &[(&str, &[u8])], data: &[u8]) -> Vec<u8> {
    let header = fields(header);
    let mut bytes = (header.len() as u32).to_le_bytes().to_vec();
    bytes.extend(header);
    bytes.extend((data.len() as u32).to_le_bytes());
    bytes.extend(data);
    bytes
}

fn connection(id: u32) -> Vec<u8> {
    let topic = TOPICS[id as usize].as_bytes();
    let definition = b"time stamp\nfloat64 x\nfloat64 y\nfloat64 theta\n";
    let data = fields(&[
        ("topic", topic),
        ("type", b"my_msgs/Pose"),
        ("md5sum", b"0"),
        ("message_definition", definition),
    ]);
    record(&[("op", &[op::CONNECTION]), ("conn", &id.to_le_bytes()), ("topic", topic)], &data)
}

fn compress(compression: &str, data: &[u8]) -> Vec<u8> {
    match compression {
        "bz2" => {
            let mut encoder =
                bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::default());
            encoder.write_all(data).unwrap();
            encoder.finish().unwrap()
        }
        "lz4" => {
            let mut encoder = lz4::EncoderBuilder::new().build(Vec::new()).unwrap();
            encoder.write_all(data).unwrap();
            let (bytes, outcome) = encoder.finish();
            outcome.unwrap();
            bytes
        }
        _ => data.to_vec(),
    }
}

/// A bag of poses at 5.00, 5.01, ... s, and where its chunks begin.
fn bag(compression: &str) -> (Vec<u8>, Vec<usize>) {
    let header = |index_pos: u64| {
        record(
            &[
                ("op", &[3]),
                ("index_pos", &index_pos.to_le_bytes()),
                ("conn_count", &2_u32.to_le_bytes()),
                ("chunk_count", &(N / PER_CHUNK).to_le_bytes()),
            ],
            &[b' '; 100],
        )
    };
    let mut bytes = b"#ROSBAG V2.0\n".to_vec();
    bytes.extend(header(0));
    let mut starts = Vec::new();
    for first in (0..N).step_by(PER_CHUNK as usize) {
        let mut chunk = [connection(0), connection(1)].concat();
        for i in first..first + PER_CHUNK {
            let time = [5_u32.to_le_bytes(), (i * 10_000_000).to_le_bytes()].concat();
            for id in 0..2_u32 {
                let numbers = [f64::from(i), f64::from(id), 0.5];
                let numbers: Vec<u8> = numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
                let (id, data) = (id.to_le_bytes(), [time.clone(), numbers].concat());
                chunk.extend(record(&[("op", &[2]), ("conn", &id), ("time", &time)], &data));
            }
        }
        starts.push(bytes.len());
        let size = (chunk.len() as u32).to_le_bytes();
        let compression_field = ("compression", compression.as_bytes());
        bytes.extend(record(
            &[("op", &[op::CHUNK]), compression_field, ("size", &size)],
            &compress(compression, &chunk),
        ));
        for id in 0..2_u32 {
            let count = PER_CHUNK.to_le_bytes();
            let index = [("op", &[op::INDEX][..]), ("conn", &id.to_le_bytes()), ("count", &count)];
            bytes.extend(record(&index, &[]));
        }
    }
    let index_pos = bytes.len() as u64;
    let head = header(index_pos);
    bytes[13..13 + head.len()].copy_from_slice(&head);
    bytes.extend([connection(0), connection(1)].concat());
    for start in &starts {
        let counts = [[0, PER_CHUNK], [1, PER_CHUNK]].concat();
        let counts: Vec<u8> = counts.iter().flat_map(|n: &u32| n.to_le_bytes()).collect();
        let position = (*start as u64).to_le_bytes();
        bytes.extend(record(&[("op", &[op::CHUNK_INFO]), ("chunk_pos", &position)], &counts));
    }
    (bytes, starts)
}

fn read(bytes: &[u8]) -> Result<Recording, DatasetError> {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("log.bag");
    fs::write(&path, bytes).unwrap();
    BagFormat.read(&path, &Streams::default(), &ReadLimits::default())
}

fn kinds(recording: &Recording) -> Vec<RemarkKind> {
    recording.remarks.iter().map(|remark| remark.kind).collect()
}

#[test]
fn every_compression_gives_the_same_recording() {
    for compression in ["none", "bz2", "lz4"] {
        let recording = read(&bag(compression).0).unwrap();
        assert_eq!(recording.robot.x, (0..N).map(f64::from).collect::<Vec<_>>(), "{compression}");
        assert_eq!(recording.object.y, vec![1.0; N as usize]);
        assert_eq!((recording.epoch_ns, recording.robot.t[17]), (5_000_000_000, 0.17));
        assert_eq!(recording.remarks, []);
    }
}

#[test]
fn a_truncated_bag_yields_what_is_whole() {
    let (bytes, starts) = bag("bz2");
    let cut = starts[2] + 50;
    let recording = read(&bytes[..cut]).unwrap();
    assert_eq!(recording.robot.len(), 2 * PER_CHUNK as usize);
    assert_eq!(kinds(&recording), [RemarkKind::NoIndex, RemarkKind::Truncated]);
    let text = format!(
        "the file ends at byte {cut}, in the middle of what begins at byte {}; all before was read",
        starts[2]
    );
    assert_eq!(recording.remarks[1].text, text);
}

#[test]
fn a_damaged_chunk_is_left_out_and_counted() {
    for compression in ["bz2", "lz4"] {
        let (mut bytes, starts) = bag(compression);
        bytes[starts[1] + 120] ^= 0x55;
        let recording = read(&bytes).unwrap();
        assert_eq!(recording.robot.len(), 2 * PER_CHUNK as usize, "{compression}");
        assert_eq!(kinds(&recording), [RemarkKind::ChunkSkipped]);
        let remark = &recording.remarks[0];
        assert_eq!(remark.count, 2 * u64::from(PER_CHUNK));
        let begin = format!("the chunk at byte {}: ", starts[1]);
        assert!(remark.text.starts_with(&begin), "{}", remark.text);
        assert!(remark.text.ends_with("; 40 wanted messages are lost"), "{}", remark.text);
    }
}

#[test]
fn a_wrong_record_length_is_overcome_by_the_index() {
    let (mut bytes, starts) = bag("none");
    bytes[starts[1]..starts[1] + 4].copy_from_slice(&u32::MAX.to_le_bytes());
    let recording = read(&bytes).unwrap();
    assert_eq!(recording.robot.len(), 2 * PER_CHUNK as usize);
    let [remark] = recording.remarks.as_slice() else { panic!("{:?}", recording.remarks) };
    let begin = format!("bytes {} to {} hold no valid record", starts[1], starts[2]);
    assert!(remark.text.starts_with(&begin), "{}", remark.text);
}

#[test]
fn an_impossible_chunk_size_costs_its_chunk_alone() {
    let (mut bytes, starts) = bag("lz4");
    let size = bytes[starts[1]..].windows(5).position(|window| window == b"size=").unwrap();
    let at = starts[1] + size + 5;
    bytes[at..at + 4].copy_from_slice(&u32::MAX.to_le_bytes());
    let recording = read(&bytes).unwrap();
    assert!(recording.remarks[0].text.contains("bytes, not 4294967295"));
    assert_eq!(recording.robot.len(), 2 * PER_CHUNK as usize);
}

#[test]
fn a_file_that_is_no_bag_is_an_error_with_its_byte() {
    let cases: [(&[u8], u64, &str); 3] = [
        (b"", 0, "the file is empty"),
        (b"#ROSBAG V1.2\n", 0, "no ROS 1 bag of version 2.0: it does not begin with"),
        (&bag("none").0[..100], 100, "the file holds no connection that can be read"),
    ];
    for (bytes, at, what) in cases {
        let error = read(bytes).unwrap_err();
        assert!(matches!(error, DatasetError::Damaged { byte, .. } if byte == at), "{error}");
        assert!(error.to_string().contains(&format!("log.bag: byte {at}: {what}")), "{error}");
    }
}

proptest! {
    #[test]
    fn damage_anywhere_never_panics(
        at in any::<proptest::sample::Index>(), byte in any::<u8>(), cut in any::<bool>(),
        packed in any::<bool>()
    ) {
        let mut bytes = bag(if packed { "lz4" } else { "none" }).0;
        let at = at.index(bytes.len());
        if cut {
            bytes.truncate(at);
        } else {
            bytes[at] = byte;
        }
        if let Ok(recording) = read(&bytes) {
            prop_assert!(recording.robot.len() <= N as usize);
        }
    }
}
