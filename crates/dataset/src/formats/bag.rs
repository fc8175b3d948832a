//! ROS 1 bags, version 2.0, whole or damaged.

use std::{
    io::Read,
    ops::{ControlFlow, Range},
    path::{Path, PathBuf},
};

use super::find::{find_recordings, is_file_ending};
use crate::{
    error::DatasetError,
    format::{Inspection, LogFormat},
    log::{Channel, Container, Message, Sink, inspect_log, nothing_to_read, read_log},
    map::FileBytes,
    recording::Recording,
    remark::{Remark, RemarkKind},
    settings::Streams,
};

const MAGIC: &[u8] = b"#ROSBAG V2.0\n";
/// A chunk may grow to this many times the file's size; a damaged size beyond it is refused.
const LARGEST_GROWTH: usize = 256;

/// Kinds of records, by the `op` field of their header.
mod op {
    pub(super) const MESSAGE: u8 = 2;
    pub(super) const INDEX: u8 = 4;
    pub(super) const CHUNK: u8 = 5;
    pub(super) const CHUNK_INFO: u8 = 6;
    pub(super) const CONNECTION: u8 = 7;
}

/// The ROS 1 bag format.
pub(crate) struct BagFormat;

impl LogFormat for BagFormat {
    fn id(&self) -> &'static str {
        "ros1-bag"
    }

    fn endings(&self) -> &'static [&'static str] {
        &["bag"]
    }

    fn find(&self, dir: &Path) -> Result<Vec<PathBuf>, DatasetError> {
        let is_recording = |path: &Path| is_file_ending(path, self.endings());
        find_recordings(dir, self.id(), "files NAME.bag", &is_recording)
    }

    fn read(&self, path: &Path, streams: &Streams) -> Result<Recording, DatasetError> {
        let file = FileBytes::open(path)?;
        let log = Bag::open(path, file.bytes())?;
        read_log(path, file.sha256(), &log, streams)
    }

    fn inspect(&self, path: &Path) -> Result<Inspection, DatasetError> {
        let file = FileBytes::open(path)?;
        Ok(inspect_log(&Bag::open(path, file.bytes())?))
    }
}

/// A bag in memory.
struct Bag<'a> {
    bytes: &'a [u8],
    channels: Vec<Channel>,
    /// Where the chunks begin, as far as the index tells.
    chunk_starts: Vec<usize>,
    remarks: Vec<Remark>,
}

/// A record: its header's fields, its data, and the byte after it.
struct Record<'r> {
    header: &'r [u8],
    data: &'r [u8],
    end: usize,
}

impl<'r> Record<'r> {
    /// The record that begins at a byte; none if it is not whole.
    fn at(bytes: &'r [u8], at: usize) -> Option<Self> {
        let header = block(bytes, at)?;
        let data = block(bytes, header.end)?;
        Some(Self { end: data.end, header: &bytes[header], data: &bytes[data] })
    }

    /// A field of the header.
    fn field(&self, name: &str) -> Option<&'r [u8]> {
        field(self.header, name)
    }

    fn op(&self) -> Option<u8> {
        match self.field("op") {
            Some([op]) => Some(*op),
            _ => None,
        }
    }

    fn number(&self, name: &str) -> Option<u32> {
        Some(u32::from_le_bytes(self.field(name)?.try_into().ok()?))
    }

    fn offset(&self, name: &str) -> Option<usize> {
        usize::try_from(u64::from_le_bytes(self.field(name)?.try_into().ok()?)).ok()
    }

    /// The message's time in ns.
    fn time(&self) -> Option<i64> {
        let time: [u8; 8] = self.field("time")?.try_into().ok()?;
        let [s0, s1, s2, s3, n0, n1, n2, n3] = time;
        let sec = u32::from_le_bytes([s0, s1, s2, s3]);
        Some(i64::from(sec) * 1_000_000_000 + i64::from(u32::from_le_bytes([n0, n1, n2, n3])))
    }

    /// The channel that a connection record declares.
    fn channel(&self) -> Option<Channel> {
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        Some(Channel {
            id: self.number("conn")?,
            topic: text(self.field("topic")?),
            type_name: text(field(self.data, "type")?),
            message_encoding: "ros1".into(),
            schema_encoding: "ros1msg".into(),
            schema: field(self.data, "message_definition")?.to_vec(),
            count: 0,
        })
    }
}

/// The bytes that follow a length at `at`.
fn block(bytes: &[u8], at: usize) -> Option<Range<usize>> {
    let length = u32::from_le_bytes(*bytes.get(at..)?.first_chunk()?) as usize;
    let start = at + 4;
    let end = start.checked_add(length)?;
    (end <= bytes.len()).then_some(start..end)
}

/// The value of `name=value` among counted fields.
fn field<'b>(fields: &'b [u8], name: &str) -> Option<&'b [u8]> {
    let mut at = 0;
    while let Some(range) = block(fields, at) {
        at = range.end;
        let value = fields[range].strip_prefix(name.as_bytes());
        if let Some(value) = value.and_then(|value| value.strip_prefix(b"=")) {
            return Some(value);
        }
    }
    None
}

impl<'a> Bag<'a> {
    fn open(path: &Path, bytes: &'a [u8]) -> Result<Self, DatasetError> {
        if bytes.is_empty() {
            return Err(nothing_to_read(path, 0, "the file is empty; record it again"));
        }
        if !bytes.starts_with(MAGIC) {
            let what = "no ROS 1 bag of version 2.0: it does not begin with #ROSBAG V2.0; check \
                        `format` in [recordings], or convert an older bag with `rosbag migrate`";
            return Err(nothing_to_read(path, 0, what));
        }
        let mut bag =
            Self { bytes, channels: Vec::new(), chunk_starts: Vec::new(), remarks: Vec::new() };
        if bag.read_index().is_none() {
            bag.scan();
        }
        if bag.channels.is_empty() {
            let what = "the file holds no connection that can be read; record it again";
            return Err(nothing_to_read(path, bytes.len() as u64, what));
        }
        Ok(bag)
    }

    /// Reads connections and chunk places from the end of the bag; none if it is not whole.
    fn read_index(&mut self) -> Option<()> {
        let header = Record::at(self.bytes, MAGIC.len())?;
        let n_connections = header.number("conn_count")? as usize;
        let mut at = header.offset("index_pos").filter(|at| *at > 0)?;
        let mut counts: Vec<(u32, u64)> = Vec::new();
        let mut channels = Vec::new();
        let mut chunk_starts = Vec::new();
        while at < self.bytes.len() {
            let record = Record::at(self.bytes, at)?;
            match record.op()? {
                op::CONNECTION => channels.push(record.channel()?),
                op::CHUNK_INFO => {
                    chunk_starts.push(record.offset("chunk_pos")?);
                    counts.extend(record.data.chunks_exact(8).map(|pair| {
                        let number = |at: usize| {
                            u32::from_le_bytes([pair[at], pair[at + 1], pair[at + 2], pair[at + 3]])
                        };
                        (number(0), u64::from(number(4)))
                    }));
                }
                _ => return None,
            }
            at = record.end;
        }
        for channel in &mut channels {
            let own = counts.iter().filter(|(id, _)| *id == channel.id);
            channel.count = own.map(|(_, count)| count).sum();
        }
        chunk_starts.sort_unstable();
        (channels.len() == n_connections).then(|| {
            self.channels = channels;
            self.chunk_starts = chunk_starts;
        })
    }

    /// Collects the connections from the whole file, for want of an index.
    fn scan(&mut self) {
        let mut channels: Vec<Channel> = Vec::new();
        self.walk(&|_| true, &mut |record, _| {
            match record.op() {
                Some(op::CONNECTION) => {
                    let channel = record.channel();
                    let new = channel.filter(|new| channels.iter().all(|old| old.id != new.id));
                    channels.extend(new);
                }
                _ => {
                    let id = record.number("conn");
                    if let Some(channel) = channels.iter_mut().find(|c| Some(c.id) == id) {
                        channel.count += 1;
                    }
                }
            }
            ControlFlow::Continue(())
        });
        self.channels = channels;
        let text = "the index of the bag is missing or damaged; the file was scanned";
        let (kind, stream) = (RemarkKind::NoIndex, None);
        self.remarks.push(Remark { kind, stream, count: 1, text: text.into() });
    }

    /// Walks messages and connections, inside chunks and outside.
    fn walk(
        &self,
        wanted: &dyn Fn(u32) -> bool,
        take: &mut dyn FnMut(&Record<'_>, usize) -> ControlFlow<()>,
    ) -> Vec<Remark> {
        let mut remarks: Vec<Remark> = Vec::new();
        let mut buffer = Vec::new();
        let mut lost: Option<u64> = None;
        let mut at = MAGIC.len();
        while at < self.bytes.len() {
            let record = Record::at(self.bytes, at);
            let known = record.and_then(|record| Some((record.op()?, record)));
            let known = known.filter(|(op, _)| (op::MESSAGE..=op::CONNECTION).contains(op));
            let Some((kind, record)) = known else {
                report_lost(&mut remarks, lost.take());
                match self.chunk_starts.iter().find(|start| **start > at) {
                    Some(start) => {
                        let text = format!("bytes {at} to {start} hold no valid record");
                        remarks.push(chunk_skipped(text));
                        lost = Some(0);
                        at = *start;
                        continue;
                    }
                    None => {
                        remarks.push(truncated(at, self.bytes.len()));
                        return remarks;
                    }
                }
            };
            let flow = match kind {
                op::CHUNK => {
                    report_lost(&mut remarks, lost.take());
                    let (flow, problem) = self.read_chunk(&record, at, &mut buffer, take);
                    if let Some(problem) = problem {
                        remarks.push(chunk_skipped(format!("the chunk at byte {at}: {problem}")));
                        lost = Some(0);
                    }
                    flow
                }
                op::INDEX => {
                    let own = record.number("conn").is_some_and(wanted);
                    if let (Some(lost), true) = (&mut lost, own) {
                        *lost += u64::from(record.number("count").unwrap_or(0));
                    }
                    ControlFlow::Continue(())
                }
                op::MESSAGE | op::CONNECTION => take(&record, at),
                _ => ControlFlow::Continue(()),
            };
            if flow.is_break() {
                break;
            }
            at = record.end;
        }
        report_lost(&mut remarks, lost);
        remarks
    }

    /// Hands over the records of a chunk, and says what is wrong with it.
    fn read_chunk(
        &self,
        chunk: &Record<'_>,
        byte: usize,
        buffer: &mut Vec<u8>,
        take: &mut dyn FnMut(&Record<'_>, usize) -> ControlFlow<()>,
    ) -> (ControlFlow<()>, Option<String>) {
        let data = match self.unpack(chunk, buffer) {
            Ok(()) if buffer.is_empty() => chunk.data,
            Ok(()) => buffer.as_slice(),
            Err(problem) => return (ControlFlow::Continue(()), Some(problem)),
        };
        let mut at = 0;
        while at < data.len() {
            let Some(record) = Record::at(data, at) else {
                let problem = format!("its records end at byte {at} of {}", data.len());
                return (ControlFlow::Continue(()), Some(problem));
            };
            if take(&record, byte).is_break() {
                return (ControlFlow::Break(()), None);
            }
            at = record.end;
        }
        (ControlFlow::Continue(()), None)
    }

    /// Decompresses a chunk into the buffer, which stays empty for an uncompressed one.
    fn unpack(&self, chunk: &Record<'_>, buffer: &mut Vec<u8>) -> Result<(), String> {
        buffer.clear();
        let size = chunk.number("size").ok_or("no size in its header")? as usize;
        let limit = self.bytes.len().saturating_mul(LARGEST_GROWTH);
        if size > limit {
            return Err(format!("its size of {size} bytes is impossible for this file"));
        }
        let limit = size as u64 + 1;
        let unpacked = match chunk.field("compression") {
            Some(b"none") => return Ok(()),
            Some(b"bz2") => bzip2::read::BzDecoder::new(chunk.data).take(limit).read_to_end(buffer),
            Some(b"lz4") => lz4::Decoder::new(chunk.data)
                .and_then(|decoder| decoder.take(limit).read_to_end(buffer)),
            other => {
                let name = String::from_utf8_lossy(other.unwrap_or_default());
                return Err(format!("compression `{name}` is none of none, bz2 and lz4"));
            }
        };
        match unpacked {
            Ok(length) if length == size => Ok(()),
            Ok(length) => Err(format!("it unpacks to {length} bytes, not {size}")),
            Err(error) => Err(format!("it does not unpack: {error}")),
        }
    }
}

impl Container for Bag<'_> {
    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn remarks(&self) -> &[Remark] {
        &self.remarks
    }

    fn visit(&self, wanted: &dyn Fn(u32) -> bool, sink: &mut Sink<'_>) -> Vec<Remark> {
        self.walk(wanted, &mut |record, byte| {
            let message = (record.op() == Some(op::MESSAGE)).then(|| {
                let channel = record.number("conn").filter(|id| wanted(*id))?;
                let (data, byte) = (record.data, byte as u64);
                Some(Message { channel, log_time: record.time()?, data, byte })
            });
            message.flatten().map_or(ControlFlow::Continue(()), |message| sink(&message))
        })
    }
}

fn chunk_skipped(text: String) -> Remark {
    Remark { kind: RemarkKind::ChunkSkipped, stream: None, count: 0, text }
}

fn truncated(at: usize, length: usize) -> Remark {
    let text = format!(
        "the file ends at byte {length}, in the middle of what begins at byte {at}; all before \
         was read"
    );
    Remark { kind: RemarkKind::Truncated, stream: None, count: 1, text }
}

/// Completes the last remark with the messages that were lost.
fn report_lost(remarks: &mut [Remark], lost: Option<u64>) {
    if let (Some(remark), Some(lost)) = (remarks.last_mut(), lost) {
        remark.count = lost;
        let lost = match lost {
            0 => "an unknown number of messages is lost".to_owned(),
            count => format!("{count} wanted messages are lost"),
        };
        remark.text = format!("{}; {lost}", remark.text);
    }
}

#[cfg(test)]
mod tests;
