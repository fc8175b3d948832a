//! Chunks of an MCAP file, unpacked and checked by several threads ahead of the one that reads them.

use mcap::records::op;
use rayon::iter::{IntoParallelRefMutIterator, ParallelIterator};

use super::mcap_record::{Chunk, PREFIX, record_at};
use crate::input::unpack::{Budget, Compression, UnpackError, Unpacked};

/// A few chunks at a time, in the order of the file.
pub(super) struct Ahead<'a> {
    bytes: &'a [u8],
    budget: Budget<'a>,
    slots: Vec<Slot>,
    /// How many of the slots hold chunks.
    n_taken: usize,
}

/// A chunk with its records.
#[derive(Default)]
struct Slot {
    /// Where it begins.
    at: usize,
    records: Unpacked,
    /// Check sum of its records, if it has one.
    crc: u32,
}

/// Chunks for each thread.
const CHUNKS_PER_THREAD: usize = 2;
/// Bytes that the chunks after the first may claim to unpack to, together.
const MOST_BYTES: u64 = 1 << 25;

impl<'a> Ahead<'a> {
    pub(super) fn new(bytes: &'a [u8], budget: Budget<'a>) -> Self {
        let n = match rayon::current_num_threads() {
            1 => 1,
            n => CHUNKS_PER_THREAD * n,
        };
        Self { bytes, budget, slots: (0..n).map(|_| Slot::default()).collect(), n_taken: 0 }
    }

    /// The records of the chunk at a byte, whose check sum holds if it has one.
    ///
    /// - `wants`: whether one that begins at a byte after it will be asked for.
    pub(super) fn records(
        &mut self,
        chunk: &Chunk<'a>,
        at: usize,
        wants: impl Fn(usize) -> bool,
    ) -> Result<&[u8], UnpackError> {
        let known =
            |ahead: &Self| ahead.slots[..ahead.n_taken].iter().position(|slot| slot.at == at);
        let place = known(self).unwrap_or_else(|| {
            self.unpack_from(at, wants);
            0
        });
        let slot = &self.slots[place];
        let records = match compression(chunk)? {
            None => chunk.data,
            Some(_) => self.budget.admit(&slot.records, chunk.unpacked_size, at as u64)?,
        };
        match slot.crc == chunk.crc {
            true => Ok(records),
            false => Err(UnpackError::Damaged(format!(
                "its check sum is {:08x}, not {:08x}",
                slot.crc, chunk.crc
            ))),
        }
    }

    /// Unpacks the chunk at a byte, and those after it that are wanted.
    fn unpack_from(&mut self, first: usize, wants: impl Fn(usize) -> bool) {
        let (mut at, mut size) = (first, 0_u64);
        self.n_taken = 0;
        while let (Some(slot), Some((opcode, body))) =
            (self.slots.get_mut(self.n_taken), record_at(self.bytes, at))
        {
            if matches!(opcode, op::DATA_END | op::FOOTER) {
                break;
            }
            if let (op::CHUNK, Some(chunk)) = (opcode, Chunk::parse(body)) {
                let is_first = at == first;
                if is_first || wants(at) {
                    size = size.saturating_add(if is_first { 0 } else { chunk.unpacked_size });
                    if size > MOST_BYTES {
                        break;
                    }
                    slot.at = at;
                    self.n_taken += 1;
                }
            }
            at += PREFIX + body.len();
        }
        let (bytes, allowed) = (self.bytes, self.budget.allowed());
        match &mut self.slots[..self.n_taken] {
            [one] => one.unpack(bytes, allowed),
            several => several.par_iter_mut().for_each(|slot| slot.unpack(bytes, allowed)),
        }
    }
}

impl Slot {
    fn unpack(&mut self, bytes: &[u8], allowed: u64) {
        let chunk = record_at(bytes, self.at).and_then(|(_, body)| Chunk::parse(body));
        let Some(chunk) = chunk else { return };
        let records = match compression(&chunk) {
            Ok(None) => chunk.data,
            Ok(Some(compression)) => {
                self.records.unpack(compression, chunk.data, chunk.unpacked_size.min(allowed));
                self.records.bytes()
            }
            Err(_) => return,
        };
        self.crc = if chunk.crc == 0 { 0 } else { crc32fast::hash(records) };
    }
}

/// How the records of a chunk are compressed, if they are.
fn compression(chunk: &Chunk<'_>) -> Result<Option<Compression>, UnpackError> {
    match chunk.compression {
        "" => Ok(None),
        "lz4" => Ok(Some(Compression::Lz4)),
        "zstd" => Ok(Some(Compression::Zstd)),
        other => {
            let what = format!("compression `{other}` is none of none, lz4 and zstd");
            Err(UnpackError::Damaged(what))
        }
    }
}
