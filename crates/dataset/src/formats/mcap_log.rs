//! MCAP logs of any profile, whole or damaged.

use std::{
    collections::{BTreeMap, btree_map::Entry},
    ops::ControlFlow,
    path::Path,
};

use mcap::{MAGIC, records::op};

use super::{
    mcap_ahead::Ahead,
    mcap_damage::Damage,
    mcap_record::{ChannelRecord, Chunk, PREFIX, Record, Schema, Summary, record_at},
};
use crate::formats::channel::ChannelList;
use crate::formats::container::{Channel, Container, Message, Sink};
use crate::formats::format::{Inspection, LogFormat};
use crate::formats::log::{inspect_log, nothing_to_read, read_log};
use crate::input::caught::caught;
use crate::input::limits::ReadLimits;
use crate::input::map::FileBytes;
use crate::input::unpack::{Budget, UnpackError};
use crate::recording::Recording;
use crate::recording::settings::Streams;
use crate::{
    error::DatasetError,
    remark::{Remark, RemarkKind},
};

/// The MCAP format.
pub(crate) struct McapFormat;

impl LogFormat for McapFormat {
    fn id(&self) -> &'static str {
        "mcap"
    }

    fn endings(&self) -> &'static [&'static str] {
        &["mcap"]
    }

    fn read(
        &self,
        path: &Path,
        streams: &Streams,
        limits: &ReadLimits,
    ) -> Result<Recording, DatasetError> {
        caught(path, || {
            let file = FileBytes::open(path, limits)?;
            let read = || {
                let log = McapLog::open(path, file.bytes(), limits)?;
                read_log(path, String::new(), &log, streams, limits)
            };
            let (recording, sha256) = rayon::join(read, || file.sha256());
            Ok(Recording { sha256, ..recording? })
        })
    }

    fn inspect(&self, path: &Path, limits: &ReadLimits) -> Result<Inspection, DatasetError> {
        caught(path, || {
            let file = FileBytes::open(path, limits)?;
            inspect_log(path, &McapLog::open(path, file.bytes(), limits)?, limits)
        })
    }
}

/// An MCAP file in memory.
struct McapLog<'a> {
    path: &'a Path,
    bytes: &'a [u8],
    limits: &'a ReadLimits,
    channels: Vec<Channel>,
    /// Where the chunks begin, and which channels they hold if the index tells.
    chunks: Vec<(usize, Vec<u16>)>,
    remarks: Vec<Remark>,
}

impl<'a> McapLog<'a> {
    fn open(path: &'a Path, bytes: &'a [u8], limits: &'a ReadLimits) -> Result<Self, DatasetError> {
        if bytes.is_empty() {
            return Err(nothing_to_read(path, 0, "the file is empty; record it again"));
        }
        if !bytes.starts_with(MAGIC) {
            let what = "no MCAP file: it does not begin with \\x89MCAP0; check `format` in \
                        [recordings]";
            return Err(nothing_to_read(path, 0, what));
        }
        let (channels, chunks, remarks) = (Vec::new(), Vec::new(), Vec::new());
        let mut log = Self { path, bytes, limits, channels, chunks, remarks };
        let summary = Summary::read(bytes);
        let reason = if summary.is_some() { "lists no channels" } else { "is missing or damaged" };
        if !log.use_summary(summary.unwrap_or_default())? {
            log.scan()?;
            let text = format!("the index at the end of the file {reason}; the file was scanned");
            log.remarks.push(Remark { kind: RemarkKind::NoIndex, stream: None, count: 1, text });
        }
        log.channels.sort_by_key(|channel| channel.id);
        if log.channels.is_empty() {
            let what = "the file holds no channel that can be read; record it again";
            return Err(nothing_to_read(path, bytes.len() as u64, what));
        }
        Ok(log)
    }

    /// Takes the channels from the summary; false if it has none, or not all that belongs to them.
    fn use_summary(&mut self, summary: Summary<'_>) -> Walked<bool> {
        self.chunks = summary.chunks;
        // The first of several with the same number is the one that counts.
        let schemas: BTreeMap<_, _> =
            summary.schemas.iter().rev().map(|schema| (schema.id, schema)).collect();
        let records: BTreeMap<_, _> =
            summary.channels.iter().rev().map(|channel| (channel.id, channel)).collect();
        let mut list = ChannelList::new(self.path, self.limits);
        for record in records.into_values() {
            let mut channel = channel(record);
            match schemas.get(&record.schema) {
                Some(schema) => channel.set_schema(schema),
                None if record.schema == 0 => {}
                None => return Ok(false),
            }
            list.push(channel)?;
        }
        self.channels = list.finish();
        if self.channels.is_empty() {
            return Ok(false);
        }
        // Statistics need not count by channel.
        let told = summary.counts.filter(|(all, counts)| {
            *all > 0 && counts.iter().try_fold(0, |sum: u64, n| sum.checked_add(n.1)) == Some(*all)
        });
        if let Some((_, told)) = told {
            let told: BTreeMap<u32, u64> =
                told.into_iter().map(|(id, n)| (u32::from(id), n)).collect();
            for channel in &mut self.channels {
                channel.count = told.get(&channel.id).copied().unwrap_or(0);
            }
            return Ok(true);
        }
        let mut counts = counts();
        self.walk(&|_| true, &mut |record, _| {
            if let Record::Message { channel, .. } = record {
                counts[usize::from(channel)] += 1;
            }
            Ok(ControlFlow::Continue(()))
        })?;
        for channel in &mut self.channels {
            channel.count = counts[channel.id as usize];
        }
        Ok(true)
    }

    /// Collects the channels from the whole file, for want of a summary.
    fn scan(&mut self) -> Result<(), DatasetError> {
        let mut list = ChannelList::new(self.path, self.limits);
        let mut schemas: BTreeMap<u16, Channel> = BTreeMap::new();
        let mut found: BTreeMap<u16, (Channel, u16)> = BTreeMap::new();
        let mut counts = counts();
        self.walk(&|_| true, &mut |record, _| {
            match record {
                Record::Message { channel, .. } => counts[usize::from(channel)] += 1,
                Record::Schema(schema) => {
                    if let Entry::Vacant(place) = schemas.entry(schema.id) {
                        list.note([schema.name, schema.encoding, "", ""], schema.data)?;
                        place.insert(Channel::default()).set_schema(&schema);
                    }
                }
                Record::Channel(record) => {
                    if let Entry::Vacant(place) = found.entry(record.id) {
                        list.note([record.topic, record.message_encoding, "", ""], &[])?;
                        place.insert((channel(&record), record.schema));
                    }
                }
            }
            Ok(ControlFlow::Continue(()))
        })?;
        for (channel, schema) in found.into_values() {
            let count = counts[channel.id as usize];
            let schema = schemas.get(&schema).cloned().unwrap_or_default();
            let Channel { id, topic, message_encoding, .. } = channel;
            list.push(Channel { id, topic, message_encoding, count, ..schema })?;
        }
        self.channels = list.finish();
        Ok(())
    }

    /// Walks the records of the file; `wants` spares chunks without a wanted channel.
    fn walk(&self, wants: &dyn Fn(u16) -> bool, take: &mut Take<'_>) -> Walked<Vec<Remark>> {
        let mut damage = Damage::default();
        let mut ahead = Ahead::new(self.bytes, Budget::new(self.path, self.limits));
        let mut at = MAGIC.len();
        while at < self.bytes.len() {
            let Some((opcode, body)) = record_at(self.bytes, at) else {
                let next = self.chunks.partition_point(|(start, _)| *start <= at);
                match self.chunks.get(next) {
                    Some((start, _)) => {
                        damage.unreadable(at, *start);
                        at = *start;
                        continue;
                    }
                    None => break,
                }
            };
            let flow = match opcode {
                op::CHUNK if self.holds_none(at, wants) => ControlFlow::Continue(()),
                op::CHUNK => {
                    let wants = |at| !self.holds_none(at, wants);
                    walk_chunk((body, at), (&mut ahead, &wants), &mut damage, take)?
                }
                op::MESSAGE_INDEX => {
                    damage.count_lost(body, wants);
                    ControlFlow::Continue(())
                }
                op::MESSAGE | op::SCHEMA | op::CHANNEL => match Record::parse(opcode, body) {
                    Some(record) => take(record, at)?,
                    None => {
                        damage.chunk(at, NO_RECORD);
                        ControlFlow::Continue(())
                    }
                },
                op::DATA_END | op::FOOTER => return Ok(damage.finish()),
                _ => ControlFlow::Continue(()),
            };
            if flow.is_break() {
                return Ok(damage.finish());
            }
            at += PREFIX + body.len();
        }
        damage.truncated(at, self.bytes.len());
        Ok(damage.finish())
    }

    fn holds_none(&self, chunk_start: usize, wants: &dyn Fn(u16) -> bool) -> bool {
        let held = self.chunks.binary_search_by_key(&chunk_start, |(start, _)| *start);
        let held = held.ok().map(|i| &self.chunks[i].1);
        held.is_some_and(|held| !held.is_empty() && !held.iter().any(|id| wants(*id)))
    }
}

impl Container for McapLog<'_> {
    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn remarks(&self) -> &[Remark] {
        &self.remarks
    }

    fn visit(&self, wanted: &dyn Fn(u32) -> bool, sink: &mut Sink<'_>) -> Walked<Vec<Remark>> {
        // Looked up for each message of a chunk, so asked only once for each channel.
        let mut table = vec![false; N_CHANNELS];
        for channel in &self.channels {
            table[channel.id as usize] = wanted(channel.id);
        }
        self.walk(&|id| table[usize::from(id)], &mut |record, byte| match record {
            Record::Message { channel, log_time, data } if table[usize::from(channel)] => {
                let log_time = i64::try_from(log_time).unwrap_or(i64::MAX);
                sink(&Message { channel: channel.into(), log_time, data, byte: byte as u64 })
            }
            _ => Ok(ControlFlow::Continue(())),
        })
    }
}

/// How many numbers of channels there are.
const N_CHANNELS: usize = u16::MAX as usize + 1;
const NO_RECORD: &str = "a record's fields reach beyond its end";

/// Outcome of a walk that a limit may end.
type Walked<T> = Result<T, DatasetError>;
/// Takes records, with the byte of the file where they or their chunk begin, until it breaks.
type Take<'t> = dyn FnMut(Record<'_>, usize) -> Walked<ControlFlow<()>> + 't;

/// Hands over the records of one chunk after checking its check sum.
fn walk_chunk<'a>(
    (body, at): (&'a [u8], usize),
    (ahead, wants): (&mut Ahead<'a>, &dyn Fn(usize) -> bool),
    damage: &mut Damage,
    take: &mut Take<'_>,
) -> Walked<ControlFlow<()>> {
    let Some(chunk) = Chunk::parse(body) else {
        damage.chunk(at, NO_RECORD);
        return Ok(ControlFlow::Continue(()));
    };
    damage.note_checksum(chunk.crc);
    let records = match ahead.records(&chunk, at, wants) {
        Ok(records) => records,
        Err(UnpackError::OverLimit(error)) => return Err(error),
        Err(UnpackError::Damaged(what)) => {
            damage.chunk(at, &what);
            return Ok(ControlFlow::Continue(()));
        }
    };
    let mut inner = 0;
    while inner < records.len() {
        let record = record_at(records, inner);
        let Some((opcode, body)) = record else {
            damage.part(at, &format!("its records end at byte {inner} of {}", records.len()));
            break;
        };
        if matches!(opcode, op::MESSAGE | op::SCHEMA | op::CHANNEL) {
            match Record::parse(opcode, body) {
                Some(record) => {
                    if take(record, at)?.is_break() {
                        return Ok(ControlFlow::Break(()));
                    }
                }
                None => damage.part(at, NO_RECORD),
            }
        }
        inner += PREFIX + body.len();
    }
    Ok(ControlFlow::Continue(()))
}

/// A count of messages for each number of a channel.
fn counts() -> Vec<u64> {
    vec![0; N_CHANNELS]
}

/// A channel without its schema.
fn channel(record: &ChannelRecord<'_>) -> Channel {
    Channel {
        id: record.id.into(),
        topic: record.topic.into(),
        message_encoding: record.message_encoding.into(),
        ..Channel::default()
    }
}

impl Channel {
    fn set_schema(&mut self, schema: &Schema<'_>) {
        self.type_name = schema.name.into();
        self.schema_encoding = schema.encoding.into();
        self.schema = schema.data.into();
    }
}

#[cfg(test)]
mod conformance;
#[cfg(test)]
mod tests;
