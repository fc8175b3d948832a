//! ROS 1 bags, version 2.0, whole or damaged.

use std::{collections::BTreeMap, ops::ControlFlow, path::Path};

use super::bag_record::Record;
use crate::formats::channel::ChannelList;
use crate::formats::container::{Channel, Container, Message, Sink};
use crate::formats::format::{Inspection, LogFormat};
use crate::formats::log::{inspect_log, nothing_to_read, read_log};
use crate::input::caught::caught;
use crate::input::limits::ReadLimits;
use crate::input::map::FileBytes;
use crate::input::unpack::{Compression, UnpackError, Unpacker};
use crate::recording::Recording;
use crate::recording::settings::Streams;
use crate::{
    error::DatasetError,
    remark::{Remark, RemarkKind},
};

const MAGIC: &[u8] = b"#ROSBAG V2.0\n";

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

    fn read(
        &self,
        path: &Path,
        streams: &Streams,
        limits: &ReadLimits,
    ) -> Result<Recording, DatasetError> {
        caught(path, || {
            let file = FileBytes::open(path, limits)?;
            let log = Bag::open(path, file.bytes(), limits)?;
            read_log(path, file.sha256(), &log, streams, limits)
        })
    }

    fn inspect(&self, path: &Path, limits: &ReadLimits) -> Result<Inspection, DatasetError> {
        caught(path, || {
            let file = FileBytes::open(path, limits)?;
            inspect_log(path, &Bag::open(path, file.bytes(), limits)?, limits)
        })
    }
}

/// A bag in memory.
struct Bag<'a> {
    path: &'a Path,
    bytes: &'a [u8],
    limits: &'a ReadLimits,
    channels: Vec<Channel>,
    /// Where the chunks begin, as far as the index tells.
    chunk_starts: Vec<usize>,
    remarks: Vec<Remark>,
}

impl<'a> Bag<'a> {
    fn open(path: &'a Path, bytes: &'a [u8], limits: &'a ReadLimits) -> Result<Self, DatasetError> {
        if bytes.is_empty() {
            return Err(nothing_to_read(path, 0, "the file is empty; record it again"));
        }
        if !bytes.starts_with(MAGIC) {
            let what = "no ROS 1 bag of version 2.0: it does not begin with #ROSBAG V2.0; check \
                        `format` in [recordings], or convert an older bag with `rosbag migrate`";
            return Err(nothing_to_read(path, 0, what));
        }
        let (channels, chunk_starts, remarks) = (Vec::new(), Vec::new(), Vec::new());
        let mut bag = Self { path, bytes, limits, channels, chunk_starts, remarks };
        if !bag.read_index()? {
            bag.scan()?;
        }
        if bag.channels.is_empty() {
            let what = "the file holds no connection that can be read; record it again";
            return Err(nothing_to_read(path, bytes.len() as u64, what));
        }
        Ok(bag)
    }

    /// Reads connections and chunk places from the end of the bag; false if it is not whole.
    fn read_index(&mut self) -> Walked<bool> {
        let Some((records, n_connections)) = self.index_records() else { return Ok(false) };
        let mut list = ChannelList::new(self.path, self.limits);
        let mut counts: BTreeMap<u32, u64> = BTreeMap::new();
        let mut chunk_starts = Vec::new();
        for record in &records {
            if record.op() == Some(op::CHUNK_INFO) {
                let Some(start) = record.offset("chunk_pos") else { return Ok(false) };
                chunk_starts.push(start);
                for [a, b, c, d, n @ ..] in record.data.as_chunks::<8>().0 {
                    let count = counts.entry(u32::from_le_bytes([*a, *b, *c, *d])).or_default();
                    *count = count.saturating_add(u32::from_le_bytes(*n).into());
                }
            } else {
                let Some(channel) = record.channel() else { return Ok(false) };
                list.push(channel)?;
            }
        }
        let mut channels = list.finish();
        if channels.len() != n_connections {
            return Ok(false);
        }
        for channel in &mut channels {
            channel.count = counts.get(&channel.id).copied().unwrap_or_default();
        }
        chunk_starts.sort_unstable();
        (self.channels, self.chunk_starts) = (channels, chunk_starts);
        Ok(true)
    }

    /// The records of the index, and how many connections the bag should have.
    fn index_records(&self) -> Option<(Vec<Record<'a>>, usize)> {
        let header = Record::at(self.bytes, MAGIC.len())?;
        let n_connections = header.number("conn_count")? as usize;
        let mut at = header.offset("index_pos").filter(|at| *at > 0)?;
        let mut records = Vec::new();
        while at < self.bytes.len() {
            let record = Record::at(self.bytes, at)?;
            matches!(record.op()?, op::CONNECTION | op::CHUNK_INFO).then_some(())?;
            at = record.end;
            records.push(record);
        }
        Some((records, n_connections))
    }

    /// Collects the connections from the whole file, for want of an index.
    fn scan(&mut self) -> Walked<()> {
        let mut list = ChannelList::new(self.path, self.limits);
        let mut counts: BTreeMap<u32, u64> = BTreeMap::new();
        self.walk(&|_| true, &mut |record, _| {
            if let Some(id) = record.number("conn") {
                if record.op() != Some(op::CONNECTION) {
                    counts.entry(id).and_modify(|n| *n += 1);
                } else if let (false, Some(channel)) = (counts.contains_key(&id), record.channel())
                {
                    list.push(channel)?;
                    counts.insert(id, 0);
                }
            }
            Ok(ControlFlow::Continue(()))
        })?;
        self.channels = list.finish();
        for channel in &mut self.channels {
            channel.count = counts.get(&channel.id).copied().unwrap_or_default();
        }
        let text = "the index of the bag is missing or damaged; the file was scanned";
        let (kind, stream) = (RemarkKind::NoIndex, None);
        self.remarks.push(Remark { kind, stream, count: 1, text: text.into() });
        Ok(())
    }

    /// Walks messages and connections, inside chunks and outside.
    fn walk(&self, wanted: &dyn Fn(u32) -> bool, take: &mut Take<'_>) -> Walked<Vec<Remark>> {
        let mut remarks: Vec<Remark> = Vec::new();
        let mut unpacker = Unpacker::new(self.path, self.limits);
        let mut lost: Option<u64> = None;
        let mut at = MAGIC.len();
        while at < self.bytes.len() {
            let record = Record::at(self.bytes, at);
            let known = record.and_then(|record| Some((record.op()?, record)));
            let known = known.filter(|(op, _)| (op::MESSAGE..=op::CONNECTION).contains(op));
            let Some((kind, record)) = known else {
                report_lost(&mut remarks, lost.take());
                let next = self.chunk_starts.partition_point(|start| *start <= at);
                match self.chunk_starts.get(next) {
                    Some(start) => {
                        let text = format!("bytes {at} to {start} hold no valid record");
                        remarks.push(chunk_skipped(text));
                        lost = Some(0);
                        at = *start;
                        continue;
                    }
                    None => {
                        remarks.push(truncated(at, self.bytes.len()));
                        return Ok(remarks);
                    }
                }
            };
            let flow = match kind {
                op::CHUNK => {
                    report_lost(&mut remarks, lost.take());
                    let (flow, problem) = read_chunk(&record, at, &mut unpacker, take)?;
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
                op::MESSAGE | op::CONNECTION => take(&record, at)?,
                _ => ControlFlow::Continue(()),
            };
            if flow.is_break() {
                break;
            }
            at = record.end;
        }
        report_lost(&mut remarks, lost);
        Ok(remarks)
    }
}

/// Outcome of a walk that a limit may end.
type Walked<T> = Result<T, DatasetError>;
/// Takes records, with the byte of the file where they or their chunk begin, until it breaks.
type Take<'t> = dyn FnMut(&Record<'_>, usize) -> Walked<ControlFlow<()>> + 't;

/// Hands over the records of a chunk, and says what is wrong with it.
fn read_chunk(
    chunk: &Record<'_>,
    byte: usize,
    unpacker: &mut Unpacker<'_>,
    take: &mut Take<'_>,
) -> Walked<(ControlFlow<()>, Option<String>)> {
    let data = match unpacked(chunk, byte, unpacker) {
        Ok(data) => data,
        Err(UnpackError::OverLimit(error)) => return Err(error),
        Err(UnpackError::Damaged(problem)) => {
            return Ok((ControlFlow::Continue(()), Some(problem)));
        }
    };
    let mut at = 0;
    while at < data.len() {
        let Some(record) = Record::at(data, at) else {
            let problem = format!("its records end at byte {at} of {}", data.len());
            return Ok((ControlFlow::Continue(()), Some(problem)));
        };
        if take(&record, byte)?.is_break() {
            return Ok((ControlFlow::Break(()), None));
        }
        at = record.end;
    }
    Ok((ControlFlow::Continue(()), None))
}

/// The records of a chunk.
fn unpacked<'c>(
    chunk: &Record<'c>,
    byte: usize,
    unpacker: &'c mut Unpacker<'_>,
) -> Result<&'c [u8], UnpackError> {
    let damaged = |what: String| Err(UnpackError::Damaged(what));
    let Some(size) = chunk.number("size") else { return damaged("no size in its header".into()) };
    let compression = match chunk.field("compression") {
        Some(b"none") => return Ok(chunk.data),
        Some(b"bz2") => Compression::Bzip2,
        Some(b"lz4") => Compression::Lz4,
        other => {
            let name = String::from_utf8_lossy(other.unwrap_or_default());
            return damaged(format!("compression `{name}` is none of none, bz2 and lz4"));
        }
    };
    unpacker.unpack(compression, chunk.data, size.into(), byte as u64)
}

impl Container for Bag<'_> {
    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn remarks(&self) -> &[Remark] {
        &self.remarks
    }

    fn visit(&self, wanted: &dyn Fn(u32) -> bool, sink: &mut Sink<'_>) -> Walked<Vec<Remark>> {
        self.walk(wanted, &mut |record, byte| {
            let message = (record.op() == Some(op::MESSAGE)).then(|| {
                let channel = record.number("conn").filter(|id| wanted(*id))?;
                let (data, byte) = (record.data, byte as u64);
                Some(Message { channel, log_time: record.time()?, data, byte })
            });
            message.flatten().map_or(Ok(ControlFlow::Continue(())), |message| sink(&message))
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
