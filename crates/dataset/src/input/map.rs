//! Files opened for reading; a log is mapped into memory, the crate's only unsafe code.

use std::{
    fs::{self, File, FileType},
    io::Read,
    path::Path,
};

use memmap2::Mmap;
use sha2::{Digest, Sha256};

use crate::error::DatasetError;
use crate::input::limits::{Limit, ReadLimits};

/// Opens a regular file for reading, and returns its length in bytes.
///
/// A pipe or a device could block or never end, so it is not even opened.
///
/// # Errors
/// `Io`; `NotAFile` for a folder, pipe, socket or device; `OverLimit` for a file that is longer than
/// the limits allow.
pub fn open_regular(path: &Path, limits: &ReadLimits) -> Result<(File, u64), DatasetError> {
    let io = |error| DatasetError::io("read", path, error);
    let refuse = |kind: FileType| DatasetError::NotAFile { path: path.into(), kind: word(kind) };
    let before = fs::metadata(path).map_err(io)?;
    if !before.is_file() {
        return Err(refuse(before.file_type()));
    }
    let file = File::open(path).map_err(io)?;
    let metadata = file.metadata().map_err(io)?;
    if !metadata.is_file() {
        return Err(refuse(metadata.file_type()));
    }
    let what = || "bytes in this file".to_owned();
    limits.check(path, Limit::FileBytes, what, metadata.len())?;
    Ok((file, metadata.len()))
}

/// Largest text that is read as a whole, in bytes.
const MOST_TEXT: u64 = 1 << 26;

/// Reads a text file as a whole: a manifest, a mapping, a list of sessions.
///
/// # Errors
/// `Io`; `NotAFile`; `OverLimit` beyond 64 MiB; `Damaged` where it is no UTF-8 text.
pub fn read_text(path: &Path) -> Result<String, DatasetError> {
    let io = |error| DatasetError::io("read", path, error);
    let (file, length) = open_regular(path, &ReadLimits::default())?;
    if length > MOST_TEXT {
        return Err(DatasetError::OverLimit {
            path: path.into(),
            what: "bytes in this text".into(),
            needed: length,
            limit: MOST_TEXT,
            remedy: "give the file that is meant".into(),
        });
    }
    let mut bytes = Vec::with_capacity(length as usize);
    file.take(MOST_TEXT).read_to_end(&mut bytes).map_err(io)?;
    String::from_utf8(bytes).map_err(|error| DatasetError::Damaged {
        path: path.into(),
        byte: error.utf8_error().valid_up_to() as u64,
        what: "no text in UTF-8; give the file that is meant".into(),
    })
}

/// What a path leads to, in a word.
fn word(kind: FileType) -> &'static str {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        if kind.is_fifo() {
            return "pipe";
        }
        if kind.is_socket() {
            return "socket";
        }
        if kind.is_char_device() || kind.is_block_device() {
            return "device";
        }
    }
    if kind.is_dir() { "folder" } else { "special file" }
}

/// The bytes of a file.
pub(crate) enum FileBytes {
    Mapped(Mmap),
    /// An empty file cannot be mapped on every system.
    Empty,
}

impl FileBytes {
    /// Maps a regular file for reading.
    #[allow(unsafe_code, reason = "mapping is what keeps memory flat over large logs")]
    pub(crate) fn open(path: &Path, limits: &ReadLimits) -> Result<Self, DatasetError> {
        let (file, length) = open_regular(path, limits)?;
        if length == 0 {
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

impl AsRef<[u8]> for FileBytes {
    fn as_ref(&self) -> &[u8] {
        self.bytes()
    }
}

/// SHA-256 over parts one after the other, in lower-case hexadecimal digits.
pub(crate) fn sha256<'a>(parts: impl IntoIterator<Item = &'a [u8]>) -> String {
    let mut hasher = Sha256::new();
    for part in parts {
        hasher.update(part);
    }
    format!("{:x}", hasher.finalize())
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::{FileBytes, read_text, sha256};
    use crate::input::limits::{Limit, ReadLimits};

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
        let limits = ReadLimits::default();
        assert!(FileBytes::open(&path, &limits).unwrap().bytes().is_empty());
        let error = FileBytes::open(&dir.path().join("none"), &limits).err().unwrap().to_string();
        assert!(error.starts_with("cannot read ") && error.contains("none"), "{error}");
    }

    #[test]
    fn a_file_that_is_too_long_is_not_mapped() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("long");
        fs::File::create(&path).unwrap().set_len(1 << 40).unwrap();
        let message = |error: crate::DatasetError| error.to_string();
        let error = message(FileBytes::open(&path, &ReadLimits::default()).err().unwrap());
        assert!(error.contains("at least 1099511627776 bytes in this file"), "{error}");
        assert!(error.contains("raise file_bytes in [limits]"), "{error}");
        let error = message(read_text(&path).unwrap_err());
        assert!(error.contains("1099511627776 bytes"), "{error}");
        fs::write(&path, b"abc").unwrap();
        let limits = ReadLimits::default().with(Limit::FileBytes, 2);
        assert!(FileBytes::open(&path, &limits).is_err());
        assert_eq!(read_text(&path).unwrap(), "abc");
    }

    #[cfg(unix)]
    #[test]
    fn only_regular_files_are_opened() {
        let dir = tempfile::tempdir().unwrap();
        let pipe = dir.path().join("pipe");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status().unwrap();
        assert!(made.success());
        let socket = dir.path().join("socket");
        let _listener = std::os::unix::net::UnixListener::bind(&socket).unwrap();
        let paths = [(pipe.as_path(), "pipe"), (&socket, "socket"), (dir.path(), "folder")];
        for (path, kind) in paths.into_iter().chain([("/dev/zero".as_ref(), "device")]) {
            let expected = format!("{}: this is a {kind}; give a regular file", path.display());
            let error = FileBytes::open(path, &ReadLimits::default()).err().unwrap();
            assert_eq!(error.to_string(), expected);
            assert_eq!(read_text(path).unwrap_err().to_string(), expected);
        }
    }
}
