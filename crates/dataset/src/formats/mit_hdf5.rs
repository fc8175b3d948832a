//! The MIT push data set as HDF5: one file a push, three data sets of rows.

use std::path::Path;

use hdf5_pure::{File, FormatError, Source};

use super::mit_rows::{Rows, inspect_rows, recording_of_rows};
use crate::error::DatasetError;
use crate::formats::format::{Inspection, LogFormat};
use crate::input::caught::caught;
use crate::input::limits::{Limit, ReadLimits};
use crate::input::map::FileBytes;
use crate::recording::Recording;
use crate::recording::settings::Streams;

/// The MIT HDF5 format.
pub(crate) struct MitHdf5Format;

impl LogFormat for MitHdf5Format {
    fn id(&self) -> &'static str {
        "mit-hdf5"
    }

    fn endings(&self) -> &'static [&'static str] {
        &["h5", "hdf5"]
    }

    fn read(
        &self,
        path: &Path,
        streams: &Streams,
        limits: &ReadLimits,
    ) -> Result<Recording, DatasetError> {
        caught(path, || {
            let (sha256, file, names) = open(path, limits)?;
            let mut rows_of = |name: &str| {
                let there = names.iter().any(|known| known == name);
                there.then(|| rows(path, &file, name, limits)).transpose()
            };
            recording_of_rows(path, sha256, &names, streams, &mut rows_of)
        })
    }

    fn inspect(&self, path: &Path, limits: &ReadLimits) -> Result<Inspection, DatasetError> {
        caught(path, || {
            let (_, file, names) = open(path, limits)?;
            let mut sets = Vec::new();
            for name in &names {
                match rows(path, &file, name, limits) {
                    Ok(rows) => sets.push((name.as_str(), rows)),
                    Err(error @ DatasetError::OverLimit { .. }) => return Err(error),
                    // A data set of another shape is none of a push.
                    Err(_) => {}
                }
            }
            Ok(inspect_rows(sets.iter().map(|(name, rows)| (*name, rows.as_slice()))))
        })
    }
}

/// A mapped file as the library reads it: it reserves no more for a part than the file holds.
struct Mapped(FileBytes);

impl Source for Mapped {
    fn len(&self) -> u64 {
        self.0.bytes().len() as u64
    }

    fn read_at(&self, offset: u64, buffer: &mut [u8]) -> Result<(), FormatError> {
        let beyond = || FormatError::UnexpectedEof {
            expected: usize::try_from(offset).unwrap_or(usize::MAX).saturating_add(buffer.len()),
            available: self.0.bytes().len(),
        };
        let start = usize::try_from(offset).map_err(|_| beyond())?;
        let end = start.checked_add(buffer.len()).ok_or_else(beyond)?;
        let bytes = self.0.bytes().get(start..end).ok_or_else(beyond)?;
        buffer.copy_from_slice(bytes);
        Ok(())
    }
}

fn open(path: &Path, limits: &ReadLimits) -> Result<(String, File, Vec<String>), DatasetError> {
    let bytes = FileBytes::open(path, limits)?;
    let sha256 = bytes.sha256();
    let damaged = |what| DatasetError::Damaged { path: path.into(), byte: 0, what };
    let file = File::from_source(Mapped(bytes))
        .map_err(|error| damaged(format!("no HDF5 file that can be read: {error}")))?;
    let names = file
        .root()
        .datasets()
        .map_err(|error| damaged(format!("its list of data sets cannot be read: {error}")))?;
    limits.check(path, Limit::Channels, || "data sets".into(), names.len() as u64)?;
    Ok((sha256, file, names))
}

fn rows(path: &Path, file: &File, name: &str, limits: &ReadLimits) -> Result<Rows, DatasetError> {
    let damaged = |what: String| DatasetError::Damaged {
        path: path.into(),
        byte: 0,
        what: format!("data set {name}: {what}"),
    };
    let set = file.dataset(name).map_err(|error| damaged(error.to_string()))?;
    let shape = set.shape().map_err(|error| damaged(error.to_string()))?;
    let &[n_rows, 4] = shape.as_slice() else {
        return Err(damaged(format!("shape {shape:?}, expected rows of four numbers")));
    };
    limits.check(path, Limit::Samples, || format!("rows of {name}"), n_rows)?;
    let chunk = set.chunk_shape().map_err(|error| damaged(error.to_string()))?;
    if let Some(chunk) = chunk {
        let n_numbers = chunk.iter().fold(1_u64, |product, n| product.saturating_mul(*n));
        let what = || format!("bytes in a chunk of {name}");
        limits.check(path, Limit::ChunkBytes, what, n_numbers.saturating_mul(8))?;
        // What no chunk holds is not in the file, and would read as zeros. One kind of index
        // cannot be listed; its rows are bounded by the limit alone.
        if let Ok(chunks) = set.chunks() {
            let held = (chunks.len() as u64).saturating_mul(chunk.first().copied().unwrap_or(0));
            if held < n_rows {
                return Err(damaged(format!("{n_rows} rows, but its chunks hold at most {held}")));
            }
        }
    }
    let numbers = set.read_f64().map_err(|error| damaged(error.to_string()))?;
    let (rows, _) = numbers.as_chunks::<4>();
    Ok(rows.to_vec())
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::MitHdf5Format;
    use crate::formats::format::LogFormat;
    use crate::input::limits::ReadLimits;
    use crate::recording::Recording;
    use crate::recording::settings::Streams;
    use crate::{error::DatasetError, remark::StreamRole};

    fn read(sets: &[(&str, &[f64], [u64; 2])]) -> Result<Recording, DatasetError> {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("push.h5");
        let mut builder = hdf5_pure::FileBuilder::new();
        for (name, data, shape) in sets {
            builder.create_dataset(name).with_f64_data(data).with_shape(shape);
        }
        fs::write(&path, builder.finish().unwrap()).unwrap();
        MitHdf5Format.read(&path, &Streams::default(), &ReadLimits::default())
    }

    const ROWS: [f64; 8] = [7.25, 0.1, 0.2, 0.3, 7.5, 1.0, 2.0, 3.0];

    #[test]
    fn data_sets_become_streams_as_they_are() {
        let whole = [("tip_pose", &ROWS[..], [2, 4]), ("object_pose", &ROWS[4..], [1, 4])];
        let recording = read(&whole).unwrap();
        assert_eq!(recording.robot.t, [0.25, 0.5]);
        assert_eq!(recording.robot.theta, [0.3, 3.0]);
        assert_eq!(recording.object.x, [1.0]);
        assert_eq!(recording.wrench, None);
    }

    #[test]
    fn a_missing_set_and_a_wrong_shape_are_errors() {
        let error = read(&[("tip_pose", &ROWS, [2, 4])]).unwrap_err();
        assert!(matches!(error, DatasetError::TopicMissing { stream: StreamRole::Object, .. }));
        let error = read(&[("tip_pose", &ROWS, [4, 2])]).unwrap_err();
        assert!(error.to_string().contains("tip_pose: shape [4, 2], expected rows of four"));
    }

    #[test]
    fn a_file_that_is_no_hdf5_is_an_error() {
        let dir = tempfile::tempdir().unwrap();
        for content in [&b""[..], b"not a log"] {
            let path = dir.path().join("push.h5");
            fs::write(&path, content).unwrap();
            let error =
                MitHdf5Format.read(&path, &Streams::default(), &ReadLimits::default()).unwrap_err();
            assert!(matches!(error, DatasetError::Damaged { byte: 0, .. }), "{error}");
        }
    }
}
