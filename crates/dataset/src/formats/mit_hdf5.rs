//! The MIT push data set as HDF5: one file a push, three data sets of rows.

use std::path::{Path, PathBuf};

use hdf5_pure::File;

use super::{
    find::{find_recordings, is_file_ending},
    mit_rows::{Rows, inspect_rows, recording_of_rows},
};
use crate::{
    error::DatasetError,
    format::{Inspection, LogFormat},
    limits::ReadLimits,
    map::FileBytes,
    recording::Recording,
    settings::Streams,
};

/// The MIT HDF5 format.
pub(crate) struct MitHdf5Format;

impl LogFormat for MitHdf5Format {
    fn id(&self) -> &'static str {
        "mit-hdf5"
    }

    fn find(&self, dir: &Path) -> Result<Vec<PathBuf>, DatasetError> {
        let is_recording = |path: &Path| is_file_ending(path, &["h5", "hdf5"]);
        find_recordings(dir, self.id(), "files NAME.h5", &is_recording)
    }

    fn read(
        &self,
        path: &Path,
        streams: &Streams,
        limits: &ReadLimits,
    ) -> Result<Recording, DatasetError> {
        let (sha256, file, names) = open(path, limits)?;
        let mut rows_of = |name: &str| {
            let there = names.iter().any(|known| known == name);
            there.then(|| rows(path, &file, name)).transpose()
        };
        recording_of_rows(path, sha256, &names, streams, &mut rows_of)
    }

    fn inspect(&self, path: &Path, limits: &ReadLimits) -> Result<Inspection, DatasetError> {
        let (_, file, names) = open(path, limits)?;
        let sets: Vec<_> =
            names.iter().filter_map(|name| Some((name, rows(path, &file, name).ok()?))).collect();
        Ok(inspect_rows(sets.iter().map(|(name, rows)| (name.as_str(), rows.as_slice()))))
    }
}

fn open(path: &Path, limits: &ReadLimits) -> Result<(String, File, Vec<String>), DatasetError> {
    let bytes = FileBytes::open(path, limits)?;
    let damaged = |what| DatasetError::Damaged { path: path.into(), byte: 0, what };
    let file = File::from_bytes(bytes.bytes().to_vec())
        .map_err(|error| damaged(format!("no HDF5 file that can be read: {error}")))?;
    let names = file
        .root()
        .datasets()
        .map_err(|error| damaged(format!("its list of data sets cannot be read: {error}")))?;
    Ok((bytes.sha256(), file, names))
}

fn rows(path: &Path, file: &File, name: &str) -> Result<Rows, DatasetError> {
    let damaged = |what: String| DatasetError::Damaged {
        path: path.into(),
        byte: 0,
        what: format!("data set {name}: {what}"),
    };
    let set = file.dataset(name).map_err(|error| damaged(error.to_string()))?;
    let shape = set.shape().map_err(|error| damaged(error.to_string()))?;
    if !matches!(shape.as_slice(), [_, 4]) {
        return Err(damaged(format!("shape {shape:?}, expected rows of four numbers")));
    }
    let numbers = set.read_f64().map_err(|error| damaged(error.to_string()))?;
    let (rows, _) = numbers.as_chunks::<4>();
    Ok(rows.to_vec())
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::MitHdf5Format;
    use crate::{
        error::DatasetError, format::LogFormat, limits::ReadLimits, recording::Recording,
        remark::StreamRole, settings::Streams,
    };

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
