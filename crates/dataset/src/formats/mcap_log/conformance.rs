//! Files of every combination of what the MCAP specification leaves open, written here by hand.

use std::{ops::ControlFlow, path::Path};

use mcap::{MAGIC, records::op};

use super::McapLog;
use crate::formats::container::Container;
use crate::input::limits::ReadLimits;
use crate::{error::DatasetError, remark::RemarkKind};

/// What a file holds.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Input {
    NoData,
    OneMessage,
    OneSchemalessMessage,
    TenMessages,
    OneAttachment,
    OneMetadata,
}

const INPUTS: [Input; 6] = [
    Input::NoData,
    Input::OneMessage,
    Input::OneSchemalessMessage,
    Input::TenMessages,
    Input::OneAttachment,
    Input::OneMetadata,
];

/// How a file is written.
#[derive(Clone, Copy, Debug)]
struct Features {
    chunked: bool,
    message_index: bool,
    statistics: bool,
    repeated_schemas: bool,
    repeated_channels: bool,
    attachment_index: bool,
    metadata_index: bool,
    chunk_index: bool,
    summary_offset: bool,
    padding: bool,
}

const N_FEATURES: u32 = 10;

impl Features {
    fn of(bits: u32) -> Self {
        let has = |i: u32| bits >> i & 1 == 1;
        Self {
            chunked: has(0),
            message_index: has(1),
            statistics: has(2),
            repeated_schemas: has(3),
            repeated_channels: has(4),
            attachment_index: has(5),
            metadata_index: has(6),
            chunk_index: has(7),
            summary_offset: has(8),
            padding: has(9),
        }
    }
}

/// Channel, time of logging and data.
type Message = (u16, u64, Vec<u8>);

impl Input {
    fn messages(self) -> Vec<Message> {
        match self {
            Self::OneMessage | Self::OneSchemalessMessage => vec![(1, 2, vec![1, 2, 3])],
            Self::TenMessages => {
                (0..10).map(|i| (1 + i % 3 / 2, u64::from(i), vec![i as u8; i as usize])).collect()
            }
            Self::NoData | Self::OneAttachment | Self::OneMetadata => Vec::new(),
        }
    }

    fn channels(self) -> &'static [u16] {
        match self {
            Self::OneMessage | Self::OneSchemalessMessage => &[1],
            Self::TenMessages => &[1, 2],
            Self::NoData | Self::OneAttachment | Self::OneMetadata => &[],
        }
    }
}

fn text(text: &str) -> Vec<u8> {
    [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat()
}

/// Pairs of a channel's number and another number, after the length of all in bytes.
fn pairs(pairs: &[(u16, u64)]) -> Vec<u8> {
    let mut bytes = (10 * pairs.len() as u32).to_le_bytes().to_vec();
    for (channel, number) in pairs {
        bytes.extend(channel.to_le_bytes());
        bytes.extend(number.to_le_bytes());
    }
    bytes
}

fn numbers<const N: usize>(numbers: [u64; N]) -> Vec<u8> {
    numbers.iter().flat_map(|number| number.to_le_bytes()).collect()
}

/// A file in the making.
struct File {
    bytes: Vec<u8>,
    features: Features,
}

impl File {
    /// Appends a record; those of a later version may have more fields than we know.
    fn record(&mut self, opcode: u8, parts: &[&[u8]]) {
        let mut body = parts.concat();
        let is_open = opcode != op::MESSAGE && opcode != op::FOOTER;
        if self.features.padding && is_open {
            body.extend([1, 255, 255]);
        }
        self.bytes.push(opcode);
        self.bytes.extend((body.len() as u64).to_le_bytes());
        self.bytes.extend(body);
    }

    fn schemas(&mut self, input: Input) {
        if !input.channels().is_empty() && input != Input::OneSchemalessMessage {
            let data = text("uint8[] data");
            self.record(op::SCHEMA, &[&[1, 0], &text("Example"), &text("ros1msg"), &data]);
        }
    }

    fn channels(&mut self, input: Input) {
        let schema = [u8::from(input != Input::OneSchemalessMessage), 0];
        for id in input.channels() {
            let topic = text(&format!("topic {id}"));
            let metadata = [text("foo"), text("bar")].concat();
            let length = (metadata.len() as u32).to_le_bytes();
            let encoding = text("ros1");
            let head = id.to_le_bytes();
            self.record(op::CHANNEL, &[&head, &schema, &topic, &encoding, &length, &metadata]);
        }
    }

    fn messages(&mut self, input: Input) {
        for (channel, time, data) in input.messages() {
            let times = numbers([time, time]);
            self.record(op::MESSAGE, &[&channel.to_le_bytes(), &[9, 0, 0, 0], &times, &data]);
        }
    }

    /// Appends the data section, and returns the place and length of its chunk.
    fn data(&mut self, input: Input) -> Option<(u64, u64)> {
        if !self.features.chunked || input.channels().is_empty() {
            self.schemas(input);
            self.channels(input);
            self.messages(input);
            return None;
        }
        let mut inner = Self { bytes: Vec::new(), features: self.features };
        inner.schemas(input);
        inner.channels(input);
        inner.messages(input);
        let (records, start) = (inner.bytes, self.bytes.len() as u64);
        let crc = crc32fast::hash(&records).to_le_bytes();
        let (head, size) = (numbers([0, 9, records.len() as u64]), numbers([records.len() as u64]));
        self.record(op::CHUNK, &[&head, &crc, &text(""), &size, &records]);
        let length = self.bytes.len() as u64 - start;
        let indexed = if self.features.message_index { input.channels() } else { &[] };
        for channel in indexed {
            let own = input.messages().into_iter().filter(|message| message.0 == *channel);
            let entries: Vec<u8> = own.flat_map(|message| numbers([message.1, 0])).collect();
            let n_bytes = (entries.len() as u32).to_le_bytes();
            self.record(op::MESSAGE_INDEX, &[&channel.to_le_bytes(), &n_bytes, &entries]);
        }
        Some((start, length))
    }

    /// Appends the summary with the place of the chunk and of what else was written.
    fn summary(&mut self, input: Input, chunk: Option<(u64, u64)>, other: (u64, u64)) {
        let Features { message_index, .. } = self.features;
        if self.features.repeated_schemas {
            self.schemas(input);
        }
        if self.features.repeated_channels {
            self.channels(input);
        }
        let count = |id: &u16| input.messages().iter().filter(|m| m.0 == *id).count() as u64;
        let counts: Vec<_> = input.channels().iter().map(|id| (*id, count(id))).collect();
        if self.features.statistics {
            // Statistics may leave out the counts by channel.
            let counts = if message_index { counts.as_slice() } else { &[] };
            let n_messages = numbers([input.messages().len() as u64]);
            self.record(op::STATISTICS, &[&n_messages, &[0; 18], &numbers([0, 9]), &pairs(counts)]);
        }
        if let (true, Some((start, length))) = (self.features.chunk_index, chunk) {
            let held: Vec<_> = counts.iter().map(|(id, _)| (*id, start + length)).collect();
            let offsets = pairs(if message_index { &held } else { &[] });
            let head = numbers([0, 9, start, length]);
            let sizes = numbers([0, 0]);
            let index_length = numbers([0]);
            let parts = [&head, &offsets, &index_length, &text(""), &sizes];
            self.record(op::CHUNK_INDEX, &parts.map(Vec::as_slice));
        }
        let (start, length) = other;
        if self.features.attachment_index && input == Input::OneAttachment {
            let head = numbers([start, length, 2, 1, 3]);
            let parts = [head, text("file"), text("type")];
            self.record(op::ATTACHMENT_INDEX, &parts.each_ref().map(Vec::as_slice));
        }
        if self.features.metadata_index && input == Input::OneMetadata {
            self.record(op::METADATA_INDEX, &[&numbers([start, length]), &text("name")]);
        }
    }
}

fn file(input: Input, features: Features) -> Vec<u8> {
    let mut file = File { bytes: MAGIC.to_vec(), features };
    file.record(op::HEADER, &[&text(""), &text("")]);
    let chunk = file.data(input);
    let start = file.bytes.len() as u64;
    if input == Input::OneAttachment {
        let (times, size) = (numbers([2, 1]), numbers([3]));
        let (name, kind) = (text("file"), text("type"));
        file.record(op::ATTACHMENT, &[&times, &name, &kind, &size, &[1, 2, 3], &[0; 4]]);
    }
    if input == Input::OneMetadata {
        let entries = [text("foo"), text("bar")].concat();
        let length = (entries.len() as u32).to_le_bytes();
        file.record(op::METADATA, &[&text("name"), &length, &entries]);
    }
    let other = (start, file.bytes.len() as u64 - start);
    file.record(op::DATA_END, &[&[0; 4]]);
    let summary_start = file.bytes.len() as u64;
    file.summary(input, chunk, other);
    let offset_start = file.bytes.len() as u64;
    let has_summary = offset_start > summary_start;
    let has_offsets = has_summary && features.summary_offset;
    if has_offsets {
        let group = numbers([summary_start, offset_start - summary_start]);
        file.record(op::SUMMARY_OFFSET, &[&[op::STATISTICS], &group]);
    }
    let starts = [(has_summary, summary_start), (has_offsets, offset_start)];
    let starts = numbers(starts.map(|(has, start)| if has { start } else { 0 }));
    file.record(op::FOOTER, &[&starts, &[0; 4]]);
    file.bytes.extend(MAGIC);
    file.bytes
}

/// The messages of the channels that are wanted.
fn listed(log: &McapLog<'_>, wanted: &dyn Fn(u32) -> bool) -> Vec<Message> {
    let mut messages = Vec::new();
    let remarks = log.visit(wanted, &mut |message| {
        let channel = message.channel as u16;
        messages.push((channel, message.log_time as u64, message.data.to_vec()));
        Ok(ControlFlow::Continue(()))
    });
    assert_eq!(remarks.unwrap(), []);
    messages
}

#[test]
fn every_combination_of_features_lists_exactly_the_messages_written() {
    let (path, limits) = (Path::new("log.mcap"), ReadLimits::default());
    let mut n_cases = 0;
    for input in INPUTS {
        for bits in 0..1 << N_FEATURES {
            n_cases += 1;
            let features = Features::of(bits);
            let bytes = file(input, features);
            let log = match McapLog::open(path, &bytes, &limits) {
                Ok(log) => log,
                Err(DatasetError::Damaged { what, .. }) => {
                    assert_eq!(what, "the file holds no channel that can be read; record it again");
                    assert!(input.channels().is_empty(), "{input:?} {features:?}");
                    continue;
                }
                Err(error) => panic!("{input:?} {features:?}: {error}"),
            };
            let case = format!("{input:?} {features:?}");
            let channels: Vec<_> = log.channels().iter().map(|c| (c.id as u16, c.count)).collect();
            let written = input.messages();
            let count = |id: u16| written.iter().filter(|message| message.0 == id).count() as u64;
            let expected: Vec<_> = input.channels().iter().map(|id| (*id, count(*id))).collect();
            assert_eq!(channels, expected, "{case}");
            let name = if input == Input::OneSchemalessMessage { "" } else { "Example" };
            assert!(log.channels().iter().all(|c| c.type_name == name), "{case}");
            assert!(log.channels().iter().all(|c| c.topic == format!("topic {}", c.id)), "{case}");
            assert_eq!(listed(&log, &|_| true), written, "{case}");
            for id in input.channels() {
                let own: Vec<_> = written.iter().filter(|m| m.0 == *id).cloned().collect();
                assert_eq!(listed(&log, &|wanted| wanted == u32::from(*id)), own, "{case}");
            }
            let is_whole = features.repeated_channels
                && (features.repeated_schemas || input == Input::OneSchemalessMessage);
            let kinds: Vec<_> = log.remarks().iter().map(|remark| remark.kind).collect();
            let scanned = if is_whole { &[][..] } else { &[RemarkKind::NoIndex] };
            assert_eq!(kinds, scanned, "{case}");
        }
    }
    assert_eq!(n_cases, 6 * 1024);
}
