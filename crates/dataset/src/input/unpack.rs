//! Compressed parts of logs, unpacked within limits whatever their headers claim.

use std::{cell::RefCell, io::Read, path::Path};

use crate::error::DatasetError;
use crate::input::limits::{Limit, ReadLimits};

/// How a part of a log is compressed.
#[derive(Clone, Copy)]
pub(crate) enum Compression {
    #[cfg(feature = "bag")]
    Bzip2,
    Lz4,
    Zstd,
}

/// Why a part of a log cannot be unpacked.
pub(crate) enum UnpackError {
    /// It is damaged: the rest of the log may be whole.
    Damaged(String),
    /// It is larger than allowed: the log is not read.
    OverLimit(DatasetError),
}

/// Unpacks the compressed parts of one log, one after the other; the memory is used again.
#[cfg(any(feature = "bag", test))]
pub(crate) struct Unpacker<'a> {
    budget: Budget<'a>,
    part: Unpacked,
}

#[cfg(any(feature = "bag", test))]
impl<'a> Unpacker<'a> {
    pub(crate) fn new(path: &'a Path, limits: &'a ReadLimits) -> Self {
        Self { budget: Budget::new(path, limits), part: Unpacked::default() }
    }

    /// Unpacks one part that should grow to `claimed` bytes.
    ///
    /// Memory grows with what is unpacked and not with what is claimed.
    pub(crate) fn unpack(
        &mut self,
        compression: Compression,
        data: &[u8],
        claimed: u64,
        byte: u64,
    ) -> Result<&[u8], UnpackError> {
        self.part.unpack(compression, data, claimed.min(self.budget.allowed()));
        self.budget.admit(&self.part, claimed, byte)
    }
}

/// How many bytes the parts of one log may still grow to.
pub(crate) struct Budget<'a> {
    path: &'a Path,
    limits: &'a ReadLimits,
    /// Bytes unpacked so far.
    total: u64,
}

impl<'a> Budget<'a> {
    pub(crate) fn new(path: &'a Path, limits: &'a ReadLimits) -> Self {
        Self { path, limits, total: 0 }
    }

    /// Bytes that the next part may grow to.
    pub(crate) fn allowed(&self) -> u64 {
        let left = self.limits.of(Limit::UnpackedBytes).saturating_sub(self.total);
        self.limits.of(Limit::ChunkBytes).min(left)
    }

    /// The bytes of the next part, which was unpacked to as many bytes as it claims to have, or as were allowed
    /// then; of several parts in the order of the log.
    pub(crate) fn admit<'p>(
        &mut self,
        part: &'p Unpacked,
        claimed: u64,
        byte: u64,
    ) -> Result<&'p [u8], UnpackError> {
        let allowed = self.allowed();
        let length = (part.buffer.len() as u64).min(allowed.saturating_add(1));
        self.total += length;
        if length > allowed {
            let what = || format!("bytes in the unpacked chunk at byte {byte}");
            self.limits
                .check(self.path, Limit::ChunkBytes, what, claimed)
                .and_then(|()| {
                    let what = || format!("bytes unpacked up to the chunk at byte {byte}");
                    self.limits.check(self.path, Limit::UnpackedBytes, what, self.total)
                })
                .map_err(UnpackError::OverLimit)?;
        }
        let damaged = |what| Err(UnpackError::Damaged(what));
        match &part.outcome {
            Err(error) => damaged(format!("it does not unpack: {error}")),
            Ok(()) if length < claimed => {
                damaged(format!("it unpacks to {length} bytes, not {claimed}"))
            }
            Ok(()) if length > claimed => {
                damaged(format!("it unpacks to more than its {claimed} bytes"))
            }
            Ok(()) => Ok(&part.buffer),
        }
    }
}

/// A compressed part of a log, unpacked apart from the others; the memory is used again.
pub(crate) struct Unpacked {
    context: Option<zstd::zstd_safe::DCtx<'static>>,
    buffer: Vec<u8>,
    outcome: std::io::Result<()>,
}

impl Default for Unpacked {
    fn default() -> Self {
        Self { context: None, buffer: Vec::new(), outcome: Ok(()) }
    }
}

impl Unpacked {
    /// Unpacks at most one byte more than there should be: it shows that there is more.
    pub(crate) fn unpack(&mut self, compression: Compression, data: &[u8], most: u64) {
        self.buffer.clear();
        self.outcome = self.fill(compression, data, most.saturating_add(1));
    }

    /// What was unpacked, whether it may be or not.
    pub(crate) fn bytes(&self) -> &[u8] {
        &self.buffer
    }

    /// Unpacks at most so many bytes into the buffer.
    fn fill(&mut self, compression: Compression, data: &[u8], most: u64) -> std::io::Result<()> {
        let buffer = &mut self.buffer;
        match compression {
            #[cfg(feature = "bag")]
            Compression::Bzip2 => {
                bzip2::read::BzDecoder::new(data).take(most).read_to_end(buffer)?;
            }
            Compression::Lz4 => {
                let mut rest = data;
                while !rest.is_empty() && (buffer.len() as u64) < most {
                    let mut frame = lz4::Decoder::new(rest)?.take(most - buffer.len() as u64);
                    frame.read_to_end(buffer)?;
                    rest = frame.into_inner().finish().0;
                }
            }
            Compression::Zstd if unpack_at_once(data, most, buffer) => {}
            Compression::Zstd => {
                buffer.clear();
                let context = self.context.get_or_insert_default();
                // A context is not ready again after an error.
                let _ = context.reset(zstd::zstd_safe::ResetDirective::SessionOnly);
                let reader = zstd::stream::read::Decoder::with_context(data, context);
                reader.take(most).read_to_end(buffer)?;
            }
        }
        Ok(())
    }
}

thread_local! {
    /// Its tables take longer to make than a small part takes to unpack.
    static AT_ONCE: RefCell<zstd::zstd_safe::DCtx<'static>> = RefCell::default();
}

/// Largest part that is unpacked at once: so much memory may be taken for what a header claims.
const MOST_AT_ONCE: u64 = 1 << 22;

/// Unpacks a part into one piece of memory, without the copies of a stream; whether it came to what was claimed,
/// one byte less than `most`. What did not is for a stream, which tells how far it came.
fn unpack_at_once(data: &[u8], most: u64, buffer: &mut Vec<u8>) -> bool {
    if most > MOST_AT_ONCE {
        return false;
    }
    buffer.reserve_exact(most as usize);
    let unpacked = AT_ONCE.with_borrow_mut(|context| context.decompress(buffer, data));
    unpacked.is_ok_and(|length| length as u64 + 1 == most)
}

#[cfg(test)]
mod tests {
    use std::{io::Write, path::Path};

    use super::{Compression, UnpackError, Unpacker};
    use crate::input::limits::{Limit, ReadLimits};

    fn lz4(bytes: &[u8]) -> Vec<u8> {
        let mut encoder = lz4::EncoderBuilder::new().build(Vec::new()).unwrap();
        encoder.write_all(bytes).unwrap();
        encoder.finish().0
    }

    /// Each compression with the same bytes packed by it.
    fn packed(bytes: &[u8]) -> Vec<(Compression, Vec<u8>)> {
        vec![
            #[cfg(feature = "bag")]
            (Compression::Bzip2, {
                let mut encoder =
                    bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::fast());
                encoder.write_all(bytes).unwrap();
                encoder.finish().unwrap()
            }),
            (Compression::Lz4, lz4(bytes)),
            (Compression::Zstd, zstd::encode_all(bytes, 1).unwrap()),
        ]
    }

    fn refusal(unpacked: Result<&[u8], UnpackError>) -> String {
        match unpacked {
            Ok(bytes) => panic!("{} bytes", bytes.len()),
            Err(UnpackError::Damaged(what)) => what,
            Err(UnpackError::OverLimit(error)) => error.to_string(),
        }
    }

    #[test]
    fn what_was_packed_comes_back_whatever_the_buffer_held_before() {
        let limits = ReadLimits::default();
        let mut unpacker = Unpacker::new(Path::new("log"), &limits);
        for length in [100_000, 0, 3, 70_000] {
            let bytes: Vec<u8> = (0..length).map(|i: u32| (i % 251) as u8).collect();
            for (compression, data) in packed(&bytes) {
                let unpacked = unpacker.unpack(compression, &data, u64::from(length), 0);
                assert!(unpacked.ok().unwrap() == bytes);
                let short = &data[..data.len() / 2];
                assert!(
                    length < 4
                        || unpacker.unpack(compression, short, u64::from(length), 0).is_err()
                );
            }
        }
        let two = [lz4(b"one"), lz4(b"two")].concat();
        assert!(unpacker.unpack(Compression::Lz4, &two, 6, 0).ok().unwrap() == b"onetwo");
    }

    #[test]
    fn a_wrong_size_is_damage() {
        let limits = ReadLimits::default();
        let mut unpacker = Unpacker::new(Path::new("log"), &limits);
        for (compression, data) in packed(&[7; 1000]) {
            let what = refusal(unpacker.unpack(compression, &data, 1001, 0));
            assert_eq!(what, "it unpacks to 1000 bytes, not 1001");
            let what = refusal(unpacker.unpack(compression, &data, 999, 0));
            assert_eq!(what, "it unpacks to more than its 999 bytes");
            let what = refusal(unpacker.unpack(compression, &data, u64::MAX, 0));
            assert_eq!(what, format!("it unpacks to 1000 bytes, not {}", u64::MAX));
        }
    }

    /// 16 MiB of zeros in some kilobytes: what they would unpack to is never held.
    #[test]
    fn a_bomb_is_refused_before_it_unfolds() {
        const BOMB: u64 = 1 << 24;
        let limits = ReadLimits::default().with(Limit::ChunkBytes, 100_000);
        for (compression, data) in packed(&vec![0; BOMB as usize]) {
            let mut unpacker = Unpacker::new(Path::new("log"), &limits);
            assert!((data.len() as u64) < BOMB / 200);
            let what = refusal(unpacker.unpack(compression, &data, BOMB, 13));
            assert_eq!(
                what,
                "log: at least 16777216 bytes in the unpacked chunk at byte 13, more than the \
                 100000 allowed; if the file is sound, raise chunk_bytes in [limits] of \
                 dataset.toml"
            );
            assert!(
                unpacker.part.buffer.capacity() < 1 << 18,
                "{}",
                unpacker.part.buffer.capacity()
            );
        }
    }

    #[test]
    fn many_small_bombs_are_refused_together() {
        let limits = ReadLimits::default().with(Limit::UnpackedBytes, 2500);
        for (compression, data) in packed(&[0; 1000]) {
            let mut unpacker = Unpacker::new(Path::new("log"), &limits);
            for _ in 0..2 {
                assert!(unpacker.unpack(compression, &data, 1000, 0).is_ok());
            }
            let what = refusal(unpacker.unpack(compression, &data, 1000, 9));
            assert!(
                what.starts_with("log: at least 2501 bytes unpacked up to the chunk at byte 9")
            );
            assert!(what.contains("raise unpacked_bytes in [limits]"), "{what}");
        }
    }
}
