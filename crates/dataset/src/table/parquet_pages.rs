//! The pages of a Parquet file, walked before its library reads them.
//!
//! The library trusts what page headers say: sizes that are not there end it, or let it take memory
//! without end. Headers are in Thrift's compact protocol.

/// What a table's file and its metadata say of the pages of one column in one row group.
pub(crate) struct Chunk<'a> {
    /// The bytes between the chunk's first page and its end.
    pub(crate) bytes: &'a [u8],
    /// Where they begin in the file, for messages.
    pub(crate) start: usize,
    /// Rows of the row group.
    pub(crate) n_rows: usize,
    /// Whether pages are compressed, by Snappy.
    pub(crate) is_compressed: bool,
}

/// Kinds of pages that hold values.
const DATA: i64 = 0;
const DICTIONARY: i64 = 2;
const DATA_V2: i64 = 3;
/// Snappy's shortest copy writes 64 bytes for 2 that it reads.
const SNAPPY_GROWTH: usize = 32;
/// Structs within structs of a header.
const DEEPEST: usize = 8;

/// Checks that the pages fill the chunk, grow no more than compression can, and hold its rows.
///
/// # Errors
/// What is wrong, with its byte in the file.
pub(crate) fn check_pages(chunk: &Chunk<'_>) -> Result<(), String> {
    let mut at = 0;
    let mut n_values = 0;
    while at < chunk.bytes.len() {
        let byte = chunk.start + at;
        let mut header = Thrift { bytes: chunk.bytes, at };
        let page = Page::read(&mut header).ok_or(format!("byte {byte}: no header of a page"))?;
        let rest = chunk.bytes.len() - header.at;
        let size = |size: i64| usize::try_from(size).ok();
        let stored = size(page.stored).filter(|stored| *stored <= rest);
        let stored = stored.ok_or_else(|| {
            format!("byte {byte}: a page of {} bytes, of {rest} that are left", page.stored)
        })?;
        let most = if chunk.is_compressed { stored.saturating_mul(SNAPPY_GROWTH) } else { stored };
        if size(page.unpacked).is_none_or(|unpacked| unpacked > most) {
            return Err(format!(
                "byte {byte}: a page of {stored} bytes that would unpack to {}",
                page.unpacked
            ));
        }
        let values = size(page.n_values).filter(|values| match page.kind {
            DATA | DATA_V2 => *values <= chunk.n_rows - n_values,
            DICTIONARY => at == 0 && *values <= most,
            _ => false,
        });
        let Some(values) = values else {
            let (kind, values) = (page.kind, page.n_values);
            return Err(format!("byte {byte}: a page of kind {kind} with {values} values"));
        };
        if page.kind != DICTIONARY {
            n_values += values;
        }
        at = header.at + stored;
    }
    if n_values != chunk.n_rows {
        let byte = chunk.start;
        return Err(format!("byte {byte}: {n_values} values for {} rows", chunk.n_rows));
    }
    Ok(())
}

/// The numbers of a page's header.
#[derive(Default)]
struct Page {
    kind: i64,
    unpacked: i64,
    stored: i64,
    n_values: i64,
}

impl Page {
    fn read(thrift: &mut Thrift<'_>) -> Option<Self> {
        let mut page = Self { kind: -1, unpacked: -1, stored: -1, n_values: -1 };
        let mut last = 0;
        while let Some((id, kind)) = thrift.field(last)? {
            last = id;
            match (id, kind) {
                (1, Thrift::I32) => page.kind = thrift.integer()?,
                (2, Thrift::I32) => page.unpacked = thrift.integer()?,
                (3, Thrift::I32) => page.stored = thrift.integer()?,
                // The headers of each kind begin with the number of values.
                (5 | 7 | 8, Thrift::STRUCT) => {
                    let mut inner = 0;
                    while let Some((id, kind)) = thrift.field(inner)? {
                        inner = id;
                        match (id, kind) {
                            (1, Thrift::I32) => page.n_values = thrift.integer()?,
                            _ => thrift.skip(kind, DEEPEST)?,
                        }
                    }
                }
                _ => thrift.skip(kind, DEEPEST)?,
            }
        }
        Some(page)
    }
}

/// A place in bytes of the compact protocol; every read that goes beyond them is none.
struct Thrift<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Thrift<'_> {
    const I32: u8 = 5;
    const STRUCT: u8 = 12;

    fn byte(&mut self) -> Option<u8> {
        let byte = *self.bytes.get(self.at)?;
        self.at += 1;
        Some(byte)
    }

    fn varint(&mut self) -> Option<u64> {
        let mut value = 0;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            value |= u64::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return Some(value);
            }
        }
        None
    }

    /// An integer whose sign is its last bit.
    fn integer(&mut self) -> Option<i64> {
        let value = self.varint()?;
        Some((value >> 1).cast_signed() ^ -(value & 1).cast_signed())
    }

    /// Id and type of the next field of a struct; none at its end.
    #[allow(clippy::option_option, reason = "the end of the bytes is not the end of a struct")]
    fn field(&mut self, last: i64) -> Option<Option<(i64, u8)>> {
        let head = self.byte()?;
        let (delta, kind) = (head >> 4, head & 0x0f);
        match (delta, kind) {
            (_, 0) => Some(None),
            (0, kind) => Some(Some((self.integer()?, kind))),
            (delta, kind) => Some(Some((last.checked_add(delta.into())?, kind))),
        }
    }

    fn skip(&mut self, kind: u8, depth: usize) -> Option<()> {
        let depth = depth.checked_sub(1)?;
        match kind {
            1 | 2 => {}
            3 => drop(self.byte()?),
            4..=6 => drop(self.varint()?),
            7 => self.advance(8)?,
            8 => {
                let length = self.varint()?;
                self.advance(length)?;
            }
            9 | 10 => {
                let head = self.byte()?;
                let n = if head >> 4 == 15 { self.varint()? } else { u64::from(head >> 4) };
                for _ in 0..n {
                    // Booleans of a list have a byte each, unlike those of a struct.
                    let kind = if head & 0x0f <= 2 { 3 } else { head & 0x0f };
                    self.skip(kind, depth)?;
                }
            }
            Self::STRUCT => {
                let mut last = 0;
                while let Some((id, kind)) = self.field(last)? {
                    last = id;
                    self.skip(kind, depth)?;
                }
            }
            _ => return None,
        }
        Some(())
    }

    fn advance(&mut self, n: u64) -> Option<()> {
        let to = self.at.checked_add(usize::try_from(n).ok()?)?;
        self.bytes.get(self.at..to)?;
        self.at = to;
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::{Chunk, check_pages};

    /// A field of an i32 after another one, and its value below 64.
    fn i32_field(value: u8) -> [u8; 2] {
        [0x15, value << 1]
    }

    fn page(kind: u8, unpacked: u8, stored: u8, n_values: u8, body: usize) -> Vec<u8> {
        let numbers = [i32_field(kind), i32_field(unpacked), i32_field(stored)].concat();
        // The header of a dictionary is field 7, that of data field 5.
        let inner = if kind == 2 { 0x4c } else { 0x2c };
        [&numbers[..], &[inner], &i32_field(n_values), &[0, 0], &vec![0; body]].concat()
    }

    fn check(bytes: &[u8], n_rows: usize, is_compressed: bool) -> Result<(), String> {
        check_pages(&Chunk { bytes, start: 4, n_rows, is_compressed })
    }

    #[test]
    fn pages_that_fill_their_chunk_are_fine() {
        let pages = [page(2, 16, 16, 2, 16), page(0, 8, 8, 3, 8), page(0, 8, 8, 4, 8)].concat();
        assert_eq!(check(&pages, 7, false), Ok(()));
        assert_eq!(check(&page(0, 40, 8, 3, 8), 3, true), Ok(()));
    }

    #[test]
    fn what_headers_promise_must_be_there() {
        for (pages, n_rows, says) in [
            (page(0, 8, 9, 3, 8), 3, "a page of 9 bytes, of 8 that are left"),
            (page(0, 8, 8, 3, 8), 4, "3 values for 4 rows"),
            (page(0, 8, 8, 5, 8), 4, "a page of kind 0 with 5 values"),
            (page(1, 8, 8, 0, 8), 0, "a page of kind 1 with 0 values"),
            (page(0, 40, 8, 3, 8), 3, "would unpack to 40"),
            (vec![0x15], 1, "no header of a page"),
            (vec![0xff; 40], 1, "no header of a page"),
            ([page(0, 8, 8, 3, 8), page(2, 8, 8, 1, 8)].concat(), 3, "a page of kind 2"),
        ] {
            let message = check(&pages, n_rows, false).unwrap_err();
            assert!(message.contains(says) && message.starts_with("byte "), "{message}");
        }
    }

    #[test]
    fn a_header_that_nests_or_counts_without_end_is_refused() {
        // A struct in a struct in a struct, and a list of 2⁶³ structs of no fields.
        let long = [&[0x1c][..], &[0x1c; 5000]].concat();
        assert!(check(&long, 1, false).is_err());
        let count = [&[0x19, 0xfc][..], &[0xff; 9], &[0x01], &[0; 100]].concat();
        assert!(check(&count, 1, false).is_err());
    }
}
