//! MCAP logs of any profile, whole or damaged.

use std::{
    ops::ControlFlow,
    path::{Path, PathBuf},
};

use mcap::{
    MAGIC, McapError, McapResult, Summary, parse_record,
    records::{Record, op},
    sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions},
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

/// Opcode and length before each record.
const PREFIX: usize = 9;
/// A chunk may grow to this many times the file's size; a damaged size beyond it is refused.
const LARGEST_GROWTH: usize = 256;

/// The MCAP format.
pub(crate) struct McapFormat;

impl LogFormat for McapFormat {
    fn id(&self) -> &'static str {
        "mcap"
    }

    fn endings(&self) -> &'static [&'static str] {
        &["mcap"]
    }

    fn find(&self, dir: &Path) -> Result<Vec<PathBuf>, DatasetError> {
        let is_recording = |path: &Path| is_file_ending(path, self.endings());
        find_recordings(dir, self.id(), "files NAME.mcap", &is_recording)
    }

    fn read(&self, path: &Path, streams: &Streams) -> Result<Recording, DatasetError> {
        let file = FileBytes::open(path)?;
        let log = McapLog::open(path, file.bytes())?;
        read_log(path, file.sha256(), &log, streams)
    }

    fn inspect(&self, path: &Path) -> Result<Inspection, DatasetError> {
        let file = FileBytes::open(path)?;
        Ok(inspect_log(&McapLog::open(path, file.bytes())?))
    }
}

/// An MCAP file in memory.
struct McapLog<'a> {
    bytes: &'a [u8],
    channels: Vec<Channel>,
    /// Where the chunks begin, and which channels they hold if the index tells.
    chunks: Vec<(usize, Vec<u16>)>,
    remarks: Vec<Remark>,
}

/// A record that matters, from inside a chunk or outside.
enum Item<'r> {
    Message { channel: u16, log_time: u64, data: &'r [u8] },
    Other(Record<'r>),
}

impl<'a> McapLog<'a> {
    fn open(path: &Path, bytes: &'a [u8]) -> Result<Self, DatasetError> {
        if bytes.is_empty() {
            return Err(nothing_to_read(path, 0, "the file is empty; record it again"));
        }
        if !bytes.starts_with(MAGIC) {
            let what = "no MCAP file: it does not begin with \\x89MCAP0; check `format` in \
                        [recordings]";
            return Err(nothing_to_read(path, 0, what));
        }
        let summary = Summary::read(bytes).ok().flatten();
        let summary = summary.filter(|summary| !summary.channels.is_empty());
        let mut log = Self { bytes, channels: Vec::new(), chunks: Vec::new(), remarks: Vec::new() };
        match summary {
            Some(summary) => log.use_summary(summary),
            None => log.scan(),
        }
        log.channels.sort_by_key(|channel| channel.id);
        if log.channels.is_empty() {
            let what = "the file holds no channel that can be read; record it again";
            return Err(nothing_to_read(path, bytes.len() as u64, what));
        }
        Ok(log)
    }

    fn use_summary(&mut self, summary: Summary) {
        let counts = summary.stats.map(|stats| stats.channel_message_counts);
        for channel in summary.channels.into_values() {
            let schema = channel.schema.as_deref();
            self.channels.push(Channel {
                id: channel.id.into(),
                topic: channel.topic.clone(),
                type_name: schema.map_or(String::new(), |schema| schema.name.clone()),
                message_encoding: channel.message_encoding.clone(),
                schema_encoding: schema.map_or(String::new(), |schema| schema.encoding.clone()),
                schema: schema.map_or(Vec::new(), |schema| schema.data.to_vec()),
                count: counts
                    .as_ref()
                    .map_or(1, |counts| counts.get(&channel.id).copied().unwrap_or(0)),
            });
        }
        self.chunks = summary
            .chunk_indexes
            .iter()
            .map(|index| {
                let held = index.message_index_offsets.keys().copied().collect();
                (index.chunk_start_offset as usize, held)
            })
            .collect();
        self.chunks.sort();
    }

    /// Collects the channels from the whole file, for want of a summary.
    fn scan(&mut self) {
        let mut schemas: Vec<(u16, String, String, Vec<u8>)> = Vec::new();
        let mut channels: Vec<(Channel, u16)> = Vec::new();
        self.walk(&|_| true, &mut |item, _| {
            match item {
                Item::Message { channel, .. } => {
                    let channel =
                        channels.iter_mut().find(|(known, _)| known.id == u32::from(channel));
                    if let Some((channel, _)) = channel {
                        channel.count += 1;
                    }
                }
                Item::Other(Record::Schema { header, data }) => {
                    schemas.push((header.id, header.name, header.encoding, data.into_owned()));
                }
                Item::Other(Record::Channel(record)) => {
                    if !channels.iter().any(|(known, _)| known.id == u32::from(record.id)) {
                        let channel = Channel {
                            id: record.id.into(),
                            topic: record.topic,
                            message_encoding: record.message_encoding,
                            ..Channel::default()
                        };
                        channels.push((channel, record.schema_id));
                    }
                }
                Item::Other(_) => {}
            }
            ControlFlow::Continue(())
        });
        for (mut channel, schema_id) in channels {
            if let Some((_, name, encoding, data)) =
                schemas.iter().find(|(id, ..)| *id == schema_id)
            {
                channel.type_name.clone_from(name);
                channel.schema_encoding.clone_from(encoding);
                channel.schema.clone_from(data);
            }
            self.channels.push(channel);
        }
        let text = "the index at the end of the file is missing or damaged; the file was scanned";
        let (kind, stream) = (RemarkKind::NoIndex, None);
        self.remarks.push(Remark { kind, stream, count: 1, text: text.into() });
    }

    /// Walks the records of the file; `wants` spares chunks without a wanted channel.
    fn walk(
        &self,
        wants: &dyn Fn(u16) -> bool,
        take: &mut dyn FnMut(Item<'_>, usize) -> ControlFlow<()>,
    ) -> Vec<Remark> {
        let mut damage = Damage::default();
        let mut chunk_reader = ChunkReader::new(self.bytes.len());
        let mut at = MAGIC.len();
        while at < self.bytes.len() {
            let Some((opcode, body)) = record_at(self.bytes, at) else {
                match self.chunks.iter().find(|(start, _)| *start > at) {
                    Some((start, _)) => {
                        damage.unreadable(at, *start);
                        at = *start;
                        continue;
                    }
                    None => {
                        damage.truncated(at, self.bytes.len());
                        return damage.finish();
                    }
                }
            };
            let end = at + PREFIX + body.len();
            let flow = match opcode {
                op::CHUNK if self.holds_none(at, wants) => ControlFlow::Continue(()),
                op::CHUNK => {
                    damage.note_checksum(body);
                    let mut flow = ControlFlow::Continue(());
                    let outcome = chunk_reader.read(&self.bytes[at..end], &mut |item| {
                        if flow.is_continue() {
                            flow = take(item, at);
                        }
                    });
                    if let Err(error) = outcome {
                        damage.chunk(at, &error);
                        chunk_reader = ChunkReader::new(self.bytes.len());
                    }
                    flow
                }
                op::MESSAGE_INDEX => {
                    damage.count_lost(body, wants);
                    ControlFlow::Continue(())
                }
                op::MESSAGE | op::SCHEMA | op::CHANNEL => match item(opcode, body) {
                    Ok(item) => take(item, at),
                    Err(error) => {
                        damage.chunk(at, &error);
                        ControlFlow::Continue(())
                    }
                },
                op::DATA_END | op::FOOTER => return damage.finish(),
                _ => ControlFlow::Continue(()),
            };
            if flow.is_break() {
                return damage.finish();
            }
            at = end;
        }
        damage.truncated(at, self.bytes.len());
        damage.finish()
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

    fn visit(&self, wanted: &dyn Fn(u32) -> bool, sink: &mut Sink<'_>) -> Vec<Remark> {
        // Looked up for each message of a chunk, so asked only once for each channel.
        let mut table = vec![false; usize::from(u16::MAX) + 1];
        for channel in &self.channels {
            table[channel.id as usize] = wanted(channel.id);
        }
        self.walk(&|id| table[usize::from(id)], &mut |item, byte| match item {
            Item::Message { channel, log_time, data } if table[usize::from(channel)] => {
                let log_time = i64::try_from(log_time).unwrap_or(i64::MAX);
                sink(&Message { channel: channel.into(), log_time, data, byte: byte as u64 })
            }
            Item::Message { .. } | Item::Other(_) => ControlFlow::Continue(()),
        })
    }
}

/// The record that begins at a byte: opcode and body; none if it is not whole or not a record.
fn record_at(bytes: &[u8], at: usize) -> Option<(u8, &[u8])> {
    let prefix = bytes.get(at..)?.first_chunk::<PREFIX>()?;
    let [opcode, length @ ..] = *prefix;
    let length = usize::try_from(u64::from_le_bytes(length)).ok()?;
    let start = at + PREFIX;
    let body = bytes.get(start..start.checked_add(length)?)?;
    // Opcodes above those of the specification belong to nobody, those from 0x80 on to anybody.
    let known = (op::HEADER..=op::DATA_END).contains(&opcode) || opcode >= 0x80;
    known.then_some((opcode, body))
}

/// A record as an item; the head of a message is read by hand, as there are many of them.
fn item(opcode: u8, body: &[u8]) -> McapResult<Item<'_>> {
    const HEAD: usize = 22;
    if opcode != op::MESSAGE {
        return parse_record(opcode, body).map(Item::Other);
    }
    match body {
        [c0, c1, _, _, _, _, t0, t1, t2, t3, t4, t5, t6, t7, ..] if body.len() >= HEAD => {
            Ok(Item::Message {
                channel: u16::from_le_bytes([*c0, *c1]),
                log_time: u64::from_le_bytes([*t0, *t1, *t2, *t3, *t4, *t5, *t6, *t7]),
                data: &body[HEAD..],
            })
        }
        _ => Err(McapError::UnexpectedEoc),
    }
}

/// Unpacks chunks after checking their CRC; buffers are used again.
struct ChunkReader(LinearReader);

impl ChunkReader {
    fn new(file_length: usize) -> Self {
        let options = LinearReaderOptions::default()
            .with_skip_start_magic(true)
            .with_skip_end_magic(true)
            .with_prevalidate_chunk_crcs(true)
            .with_record_length_limit(file_length.saturating_mul(LARGEST_GROWTH));
        Self(LinearReader::new_with_options(options))
    }

    /// Hands over the records of one chunk, given as a whole record of the file.
    fn read(&mut self, chunk: &[u8], take: &mut dyn FnMut(Item<'_>)) -> McapResult<()> {
        let mut rest = chunk;
        while let Some(event) = self.0.next_event() {
            match event? {
                LinearReadEvent::ReadRequest(_) if rest.is_empty() => break,
                LinearReadEvent::ReadRequest(wanted) => {
                    let (now, later) = rest.split_at(wanted.min(rest.len()));
                    self.0.insert(now.len()).copy_from_slice(now);
                    self.0.notify_read(now.len());
                    rest = later;
                }
                LinearReadEvent::Record { data, opcode } => match opcode {
                    op::MESSAGE | op::SCHEMA | op::CHANNEL => take(item(opcode, data)?),
                    _ => {}
                },
            }
        }
        Ok(())
    }
}

/// What is found damaged on a walk.
#[derive(Default)]
struct Damage {
    remarks: Vec<Remark>,
    n_unchecked: u64,
    /// The remark on the chunk just before, whose messages its index can still count.
    last_chunk: Option<usize>,
}

impl Damage {
    fn push(&mut self, kind: RemarkKind, count: u64, text: String) {
        self.remarks.push(Remark { kind, stream: None, count, text });
    }

    fn chunk(&mut self, at: usize, error: &McapError) {
        self.last_chunk = Some(self.remarks.len());
        self.push(RemarkKind::ChunkSkipped, 0, format!("the chunk at byte {at}: {error}"));
    }

    fn unreadable(&mut self, at: usize, resumed: usize) {
        self.last_chunk = None;
        let text = format!("bytes {at} to {resumed} hold no valid record");
        self.push(RemarkKind::ChunkSkipped, 0, text);
    }

    fn truncated(&mut self, at: usize, length: usize) {
        let text = format!(
            "the file ends at byte {length}, in the middle of what begins at byte {at}; all \
             before was read"
        );
        self.push(RemarkKind::Truncated, 1, text);
    }

    /// Notes whether a chunk has a check sum: the field after two times and a size.
    fn note_checksum(&mut self, chunk: &[u8]) {
        self.last_chunk = None;
        self.n_unchecked += u64::from(chunk.get(24..28) == Some(&[0; 4]));
    }

    /// Adds the messages that an index counts to the chunk lost before it.
    fn count_lost(&mut self, index: &[u8], wants: &dyn Fn(u16) -> bool) {
        if let Some(i) = self.last_chunk
            && let Ok(Record::MessageIndex(index)) = parse_record(op::MESSAGE_INDEX, index)
            && wants(index.channel_id)
        {
            self.remarks[i].count += index.records.len() as u64;
        }
    }

    fn finish(mut self) -> Vec<Remark> {
        for remark in &mut self.remarks {
            if remark.kind == RemarkKind::ChunkSkipped {
                let lost = match remark.count {
                    0 => "an unknown number of messages is lost".to_owned(),
                    count => format!("{count} wanted messages are lost"),
                };
                remark.text = format!("{}; {lost}", remark.text);
            }
        }
        if self.n_unchecked > 0 {
            let text = "chunks carry no check sums: damage in them could go unseen".into();
            self.push(RemarkKind::NoChecksums, self.n_unchecked, text);
        }
        self.remarks
    }
}

#[cfg(test)]
mod tests;
