//! The records of a ROS 1 bag, taken from bytes that may say anything.

use std::ops::Range;

use crate::formats::container::Channel;

/// A record: its header's fields, its data, and the byte after it.
pub(super) struct Record<'r> {
    header: &'r [u8],
    pub(super) data: &'r [u8],
    pub(super) end: usize,
}

impl<'r> Record<'r> {
    /// The record that begins at a byte; none if it is not whole.
    pub(super) fn at(bytes: &'r [u8], at: usize) -> Option<Self> {
        let header = block(bytes, at)?;
        let data = block(bytes, header.end)?;
        Some(Self { end: data.end, header: &bytes[header], data: &bytes[data] })
    }

    /// A field of the header.
    pub(super) fn field(&self, name: &str) -> Option<&'r [u8]> {
        field(self.header, name)
    }

    pub(super) fn op(&self) -> Option<u8> {
        match self.field("op") {
            Some([op]) => Some(*op),
            _ => None,
        }
    }

    pub(super) fn number(&self, name: &str) -> Option<u32> {
        Some(u32::from_le_bytes(self.field(name)?.try_into().ok()?))
    }

    pub(super) fn offset(&self, name: &str) -> Option<usize> {
        usize::try_from(u64::from_le_bytes(self.field(name)?.try_into().ok()?)).ok()
    }

    /// The message's time in ns.
    pub(super) fn time(&self) -> Option<i64> {
        let time: [u8; 8] = self.field("time")?.try_into().ok()?;
        let [s0, s1, s2, s3, n0, n1, n2, n3] = time;
        let sec = u32::from_le_bytes([s0, s1, s2, s3]);
        Some(i64::from(sec) * 1_000_000_000 + i64::from(u32::from_le_bytes([n0, n1, n2, n3])))
    }

    /// The channel that a connection record declares.
    pub(super) fn channel(&self) -> Option<Channel> {
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
