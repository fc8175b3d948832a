//! ROS 1 bags of version 2.0, compressed and with their index.

use std::{
    io::{self, Write},
    path::{Path, PathBuf},
};

use super::{
    cdr::{definition, encode},
    mcap_writer::{check_stamps, earliest, topic},
    sample::{Sample, samples},
};
use crate::recording::Recording;
use crate::writers::writer::{RecordingWriter, make_dir};
use crate::{error::DatasetError, remark::StreamRole};

/// Writes a bag a recording, all of its messages in one chunk compressed by bzip2.
pub(crate) struct BagWriter;

/// Kinds of records.
mod op {
    pub(super) const MESSAGE: u8 = 2;
    pub(super) const HEADER: u8 = 3;
    pub(super) const INDEX: u8 = 4;
    pub(super) const CHUNK: u8 = 5;
    pub(super) const CHUNK_INFO: u8 = 6;
    pub(super) const CONNECTION: u8 = 7;
}

impl RecordingWriter for BagWriter {
    fn id(&self) -> &'static str {
        "ros1-bag"
    }

    fn format(&self) -> &'static str {
        "ros1-bag"
    }

    fn write(&self, recording: &Recording, dir: &Path) -> Result<PathBuf, DatasetError> {
        let path = dir.join(format!("{}.bag", recording.name));
        let streams = samples(recording, &path, self.id())?;
        check_stamps(&streams, &path, self.id())?;
        let bytes = bag(&streams).map_err(|error| DatasetError::Unwritable {
            path: path.clone(),
            format: self.id(),
            what: error.to_string(),
        })?;
        make_dir(dir)?;
        output::write(&path, &bytes)?;
        Ok(path)
    }
}

fn bag(streams: &[(StreamRole, Vec<Sample>)]) -> io::Result<Vec<u8>> {
    let connections: Vec<u8> =
        streams.iter().enumerate().flat_map(|(i, (role, _))| connection(i as u32, *role)).collect();
    let mut chunk = connections.clone();
    let mut index = vec![Vec::new(); streams.len()];
    let mut times: Vec<[u8; 8]> = Vec::new();
    let mut next = vec![0; streams.len()];
    while let Some(i) = earliest(streams, &next) {
        let (role, samples) = &streams[i];
        let sample = &samples[next[i]];
        let stamp = time(sample);
        index[i].extend(stamp);
        index[i].extend((chunk.len() as u32).to_le_bytes());
        let conn = (i as u32).to_le_bytes();
        let header = [("op", &[op::MESSAGE][..]), ("conn", &conn), ("time", &stamp)];
        chunk.extend(record(&header, &encode(*role, sample, next[i] as u32, false)));
        times.push(stamp);
        next[i] += 1;
    }
    const MAGIC: &[u8] = b"#ROSBAG V2.0\n";
    let chunk_at = (MAGIC.len() + HEADER_SIZE) as u64;
    let size = (chunk.len() as u32).to_le_bytes();
    let header = [("op", &[op::CHUNK][..]), ("compression", b"bz2"), ("size", &size)];
    let mut body = record(&header, &compressed(&chunk)?);
    let mut counts = Vec::new();
    for (i, entries) in index.iter().enumerate() {
        let (conn, count) = ((i as u32).to_le_bytes(), (entries.len() as u32 / 12).to_le_bytes());
        let header = [("op", &[op::INDEX][..]), ("ver", &ONE), ("conn", &conn), ("count", &count)];
        body.extend(record(&header, entries));
        counts.extend([conn, count].concat());
    }
    let index_at = chunk_at + body.len() as u64;
    body.extend(connections);
    let at = chunk_at.to_le_bytes();
    let n_streams = (streams.len() as u32).to_le_bytes();
    let (first, last) = (times.first().copied(), times.last().copied());
    let (first, last) = (first.unwrap_or_default(), last.unwrap_or_default());
    let header = [
        ("op", &[op::CHUNK_INFO][..]),
        ("ver", &ONE),
        ("chunk_pos", &at),
        ("start_time", &first),
        ("end_time", &last),
        ("count", &n_streams),
    ];
    body.extend(record(&header, &counts));
    Ok([MAGIC, &bag_header(index_at, n_streams), &body].concat())
}

fn compressed(chunk: &[u8]) -> io::Result<Vec<u8>> {
    let mut encoder = bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::best());
    encoder.write_all(chunk)?;
    encoder.finish()
}

const ONE: [u8; 4] = 1_u32.to_le_bytes();
/// The bag's own header is padded, so that it can be rewritten in place.
const HEADER_SIZE: usize = 4096;

fn bag_header(index_at: u64, n_connections: [u8; 4]) -> Vec<u8> {
    let index_at = index_at.to_le_bytes();
    let header = [
        ("op", &[op::HEADER][..]),
        ("index_pos", &index_at),
        ("conn_count", &n_connections),
        ("chunk_count", &ONE),
    ];
    let bare = record(&header, &[]).len();
    record(&header, &vec![b' '; HEADER_SIZE - bare])
}

fn connection(id: u32, role: StreamRole) -> Vec<u8> {
    let (kind, md5sum) = if role == StreamRole::Wrench {
        ("geometry_msgs/WrenchStamped", "d78d3cb249ce23087ade7e7d0c40cfa7")
    } else {
        ("geometry_msgs/PoseStamped", "d3812c3cbc69362b77dc0b19b345f8f5")
    };
    let (topic, definition) = (topic(role).as_bytes(), definition(role, false));
    let data = fields(&[
        ("topic", topic),
        ("type", kind.as_bytes()),
        ("md5sum", md5sum.as_bytes()),
        ("message_definition", definition.as_bytes()),
    ]);
    let conn = id.to_le_bytes();
    record(&[("op", &[op::CONNECTION]), ("conn", &conn), ("topic", topic)], &data)
}

fn time(sample: &Sample) -> [u8; 8] {
    let (sec, nanosec) = sample.stamp();
    // Checked before: 32 bits hold the seconds.
    let sec = u32::try_from(sec).unwrap_or(u32::MAX);
    (u64::from(nanosec) << 32 | u64::from(sec)).to_le_bytes()
}

fn record(header: &[(&str, &[u8])], data: &[u8]) -> Vec<u8> {
    let header = fields(header);
    let length = |bytes: &[u8]| (bytes.len() as u32).to_le_bytes();
    [&length(&header)[..], &header, &length(data), data].concat()
}

fn fields(pairs: &[(&str, &[u8])]) -> Vec<u8> {
    let field = |(name, value): &(&str, &[u8])| {
        let length = (name.len() + 1 + value.len()) as u32;
        [&length.to_le_bytes()[..], name.as_bytes(), b"=", value].concat()
    };
    pairs.iter().flat_map(field).collect()
}
