//! The records of an MCAP file that matter for reading, taken from bytes that may say anything.

use mcap::{MAGIC, records::op};

/// Opcode and length before each record.
pub(super) const PREFIX: usize = 9;
/// Length of the footer's own fields.
const FOOTER: usize = 20;

/// A record of the file or of a chunk.
pub(super) enum Record<'r> {
    Schema(Schema<'r>),
    Channel(ChannelRecord<'r>),
    Message { channel: u16, log_time: u64, data: &'r [u8] },
}

/// How the messages of a channel are laid out.
#[derive(Clone, Copy)]
pub(super) struct Schema<'r> {
    pub(super) id: u16,
    pub(super) name: &'r str,
    pub(super) encoding: &'r str,
    pub(super) data: &'r [u8],
}

/// One topic from one publisher; schema 0 is none.
pub(super) struct ChannelRecord<'r> {
    pub(super) id: u16,
    pub(super) schema: u16,
    pub(super) topic: &'r str,
    pub(super) message_encoding: &'r str,
}

/// A chunk as it stands in the file.
pub(super) struct Chunk<'r> {
    pub(super) unpacked_size: u64,
    /// Check sum of the unpacked records; 0 if there is none.
    pub(super) crc: u32,
    pub(super) compression: &'r str,
    pub(super) data: &'r [u8],
}

/// What the summary at the end of the file tells.
#[derive(Default)]
pub(super) struct Summary<'r> {
    pub(super) schemas: Vec<Schema<'r>>,
    pub(super) channels: Vec<ChannelRecord<'r>>,
    /// Where chunks begin, and which channels they hold if the index tells.
    pub(super) chunks: Vec<(usize, Vec<u16>)>,
    /// Messages in all, and in each channel.
    pub(super) counts: Option<(u64, Vec<(u16, u64)>)>,
}

/// The record that begins at a byte: opcode and body; none if it is not whole or not a record.
pub(super) fn record_at(bytes: &[u8], at: usize) -> Option<(u8, &[u8])> {
    let prefix = bytes.get(at..)?.first_chunk::<PREFIX>()?;
    let [opcode, length @ ..] = *prefix;
    let length = usize::try_from(u64::from_le_bytes(length)).ok()?;
    let start = at + PREFIX;
    let body = bytes.get(start..start.checked_add(length)?)?;
    // Opcodes above those of the specification belong to nobody, those from 0x80 on to anybody.
    let known = (op::HEADER..=op::DATA_END).contains(&opcode) || opcode >= 0x80;
    known.then_some((opcode, body))
}

impl<'r> Record<'r> {
    /// A schema, channel or message; none if its fields do not fit into it.
    ///
    /// Bytes after the last field are of a later version of the format.
    pub(super) fn parse(opcode: u8, body: &'r [u8]) -> Option<Self> {
        match opcode {
            op::SCHEMA => Schema::parse(body).map(Self::Schema),
            op::CHANNEL => ChannelRecord::parse(body).map(Self::Channel),
            _ => {
                let mut fields = Fields(body);
                let channel = fields.u16()?;
                let _sequence = fields.u32()?;
                let log_time = fields.u64()?;
                let _publish_time = fields.u64()?;
                Some(Self::Message { channel, log_time, data: fields.0 })
            }
        }
    }
}

impl<'r> Schema<'r> {
    fn parse(body: &'r [u8]) -> Option<Self> {
        let mut fields = Fields(body);
        Some(Self {
            id: fields.u16()?,
            name: fields.text()?,
            encoding: fields.text()?,
            data: fields.bytes()?,
        })
    }
}

impl<'r> ChannelRecord<'r> {
    fn parse(body: &'r [u8]) -> Option<Self> {
        let mut fields = Fields(body);
        Some(Self {
            id: fields.u16()?,
            schema: fields.u16()?,
            topic: fields.text()?,
            message_encoding: fields.text()?,
        })
    }
}

impl<'r> Chunk<'r> {
    pub(super) fn parse(body: &'r [u8]) -> Option<Self> {
        let mut fields = Fields(body);
        let _times = (fields.u64()?, fields.u64()?);
        Some(Self {
            unpacked_size: fields.u64()?,
            crc: fields.u32()?,
            compression: fields.text()?,
            data: {
                let length = fields.u64()?;
                fields.take(usize::try_from(length).ok()?)?
            },
        })
    }
}

/// The channel and the number of messages of a message index.
pub(super) fn message_index(body: &[u8]) -> Option<(u16, u64)> {
    let mut fields = Fields(body);
    Some((fields.u16()?, fields.bytes()?.len() as u64 / 16))
}

impl<'r> Summary<'r> {
    /// The summary that the footer points to; none if there is none or it is damaged.
    pub(super) fn read(bytes: &'r [u8]) -> Option<Self> {
        let footer = bytes.strip_suffix(MAGIC)?;
        let footer_at = footer.len().checked_sub(PREFIX + FOOTER)?;
        let (op::FOOTER, body) = record_at(footer, footer_at)? else { return None };
        let mut at = usize::try_from(Fields(body).u64()?).ok().filter(|start| *start > 0)?;
        let mut summary = Self::default();
        while at < footer_at {
            let (opcode, body) = record_at(&footer[..footer_at], at)?;
            match opcode {
                op::SCHEMA => summary.schemas.push(Schema::parse(body)?),
                op::CHANNEL => summary.channels.push(ChannelRecord::parse(body)?),
                op::CHUNK_INDEX => summary.chunks.push(chunk_index(body)?),
                op::STATISTICS => summary.counts = Some(statistics(body)?),
                // These belong before the summary.
                op::HEADER | op::MESSAGE | op::CHUNK | op::DATA_END => return None,
                _ => {}
            }
            at += PREFIX + body.len();
        }
        summary.chunks.sort();
        Some(summary)
    }
}

fn chunk_index(body: &[u8]) -> Option<(usize, Vec<u16>)> {
    let mut fields = Fields(body);
    let _times = (fields.u64()?, fields.u64()?);
    let start = usize::try_from(fields.u64()?).ok()?;
    let _length = fields.u64()?;
    let (offsets, _) = fields.bytes()?.as_chunks::<10>();
    Some((start, offsets.iter().map(|[a, b, ..]| u16::from_le_bytes([*a, *b])).collect()))
}

fn statistics(body: &[u8]) -> Option<(u64, Vec<(u16, u64)>)> {
    let mut fields = Fields(body);
    let n_messages = fields.u64()?;
    let _counts_and_times = fields.take(2 + 4 * 4 + 2 * 8)?;
    let (counts, _) = fields.bytes()?.as_chunks::<10>();
    let pair = |[a, b, n @ ..]: &[u8; 10]| (u16::from_le_bytes([*a, *b]), u64::from_le_bytes(*n));
    Some((n_messages, counts.iter().map(pair).collect()))
}

/// Fields one after the other; none beyond the end.
struct Fields<'r>(&'r [u8]);

impl<'r> Fields<'r> {
    fn take(&mut self, n: usize) -> Option<&'r [u8]> {
        self.0.split_off(..n)
    }

    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.take(N)?.first_chunk().copied()
    }

    fn u16(&mut self) -> Option<u16> {
        self.array().map(u16::from_le_bytes)
    }

    fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Option<u64> {
        self.array().map(u64::from_le_bytes)
    }

    /// Bytes after their 32-bit length.
    fn bytes(&mut self) -> Option<&'r [u8]> {
        let length = self.u32()?;
        self.take(usize::try_from(length).ok()?)
    }

    fn text(&mut self) -> Option<&'r str> {
        str::from_utf8(self.bytes()?).ok()
    }
}
