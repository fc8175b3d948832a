//! MIT HDF5 files, as the MIT HDF5 format reads them.

use std::path::{Path, PathBuf};

use super::sample::samples;
use crate::error::DatasetError;
use crate::formats::default_data_set;
use crate::recording::Recording;
use crate::writers::writer::{RecordingWriter, make_dir};

/// Writes an HDF5 file a recording; a torque that was not recorded is written as 0.
pub(crate) struct MitHdf5Writer;

impl RecordingWriter for MitHdf5Writer {
    fn id(&self) -> &'static str {
        "mit-hdf5"
    }

    fn format(&self) -> &'static str {
        "mit-hdf5"
    }

    fn write(&self, recording: &Recording, dir: &Path) -> Result<PathBuf, DatasetError> {
        let path = dir.join(format!("{}.h5", recording.name));
        let mut builder = hdf5_pure::FileBuilder::new();
        for (role, samples) in samples(recording, &path, self.id())? {
            let rows = samples.iter().flat_map(|sample| {
                let [a, b, c] = sample.values;
                [sample.time_us as f64 / 1e6, a, b, c]
            });
            let set = builder.create_dataset(default_data_set(role));
            set.with_f64_data(&rows.collect::<Vec<_>>()).with_shape(&[samples.len() as u64, 4]);
        }
        let bytes = builder.finish().map_err(|error| DatasetError::Unwritable {
            path: path.clone(),
            format: self.id(),
            what: error.to_string(),
        })?;
        make_dir(dir)?;
        output::write(&path, &bytes)?;
        Ok(path)
    }
}
