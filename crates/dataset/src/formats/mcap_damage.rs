//! What a walk through an MCAP file finds damaged, as remarks.

use super::mcap_record::message_index;
use crate::remark::{Remark, RemarkKind};

/// What is found damaged on a walk.
#[derive(Default)]
pub(super) struct Damage {
    remarks: Vec<Remark>,
    n_unchecked: u64,
    /// The remark on the chunk just before, whose messages its index can still count.
    last_chunk: Option<usize>,
}

impl Damage {
    fn push(&mut self, kind: RemarkKind, count: u64, text: String) {
        self.remarks.push(Remark { kind, stream: None, count, text });
    }

    /// A chunk of which nothing is read.
    pub(super) fn chunk(&mut self, at: usize, what: &str) {
        self.last_chunk = Some(self.remarks.len());
        self.push(RemarkKind::ChunkSkipped, 0, format!("the chunk at byte {at}: {what}"));
    }

    /// A chunk of which the part before was read.
    pub(super) fn part(&mut self, at: usize, what: &str) {
        self.chunk(at, what);
        self.last_chunk = None;
    }

    /// Notes whether a chunk has a check sum.
    pub(super) fn note_checksum(&mut self, crc: u32) {
        self.last_chunk = None;
        self.n_unchecked += u64::from(crc == 0);
    }

    pub(super) fn unreadable(&mut self, at: usize, resumed: usize) {
        self.last_chunk = None;
        let text = format!("bytes {at} to {resumed} hold no valid record");
        self.push(RemarkKind::ChunkSkipped, 0, text);
    }

    pub(super) fn truncated(&mut self, at: usize, length: usize) {
        let text = format!(
            "the file ends at byte {length}, in the middle of what begins at byte {at}; all \
             before was read"
        );
        self.push(RemarkKind::Truncated, 1, text);
    }

    /// Adds the messages that an index counts to the chunk lost before it.
    pub(super) fn count_lost(&mut self, index: &[u8], wants: &dyn Fn(u16) -> bool) {
        if let Some(i) = self.last_chunk
            && let Some((channel, n_messages)) = message_index(index)
            && wants(channel)
        {
            self.remarks[i].count += n_messages;
        }
    }

    pub(super) fn finish(mut self) -> Vec<Remark> {
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
