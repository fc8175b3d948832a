//! A log file mapped into memory: the crate's only unsafe code.

use std::{fs::File, path::Path};

use memmap2::Mmap;
use sha2::{Digest, Sha256};

use crate::error::DatasetError;

/// The bytes of a file.
pub(crate) enum FileBytes {
    Mapped(Mmap),
    /// An empty file cannot be mapped on every system.
    Empty,
}

impl FileBytes {
    /// Maps a file for reading.
    #[allow(unsafe_code, reason = "mapping is what keeps memory flat over large logs")]
    pub(crate) fn open(path: &Path) -> Result<Self, DatasetError> {
        let file = File::open(path).map_err(|error| DatasetError::io("read", path, error))?;
        let metadata = file.metadata().map_err(|error| DatasetError::io("read", path, error))?;
        if metadata.len() == 0 {
            return Ok(Self::Empty);
        }
        // SAFETY: the map is only read. A log that another process cuts short while it is read
        // would end this process with SIGBUS; logs are written once and read afterwards.
        let map = unsafe { Mmap::map(&file) };
        map.map(Self::Mapped).map_err(|error| DatasetError::io("read", path, error))
    }

    /// The bytes, which exist as long as the map.
    pub(crate) fn bytes(&self) -> &[u8] {
        match self {
            Self::Mapped(map) => map,
            Self::Empty => &[],
        }
    }

    /// SHA-256 of the bytes in lower-case hexadecimal digits.
    pub(crate) fn sha256(&self) -> String {
        sha256([self.bytes()])
    }
}

/// SHA-256 over parts one after the other, in lower-case hexadecimal digits.
pub(crate) fn sha256<'a>(parts: impl IntoIterator<Item = &'a [u8]>) -> String {
    let mut hasher = Sha256::new();
    for part in parts {
        hasher.update(part);
    }
    hasher.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::{FileBytes, sha256};

    #[test]
    fn the_hash_is_the_standards() {
        let abc = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(sha256([b"a".as_slice(), b"bc"]), abc);
    }

    #[test]
    fn an_empty_file_has_no_bytes() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("empty");
        fs::write(&path, b"").unwrap();
        assert!(FileBytes::open(&path).unwrap().bytes().is_empty());
        let error = FileBytes::open(&dir.path().join("none")).err().unwrap().to_string();
        assert!(error.starts_with("cannot read ") && error.contains("none"), "{error}");
    }
}
