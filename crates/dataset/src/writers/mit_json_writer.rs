//! MIT JSON files, as the MIT JSON format reads them.

use std::{
    fmt::Write as _,
    path::{Path, PathBuf},
};

use super::sample::samples;
use crate::error::DatasetError;
use crate::formats::default_data_set;
use crate::recording::Recording;
use crate::writers::writer::{RecordingWriter, make_dir};

/// Writes a JSON file a recording; a torque that was not recorded is written as 0.
pub(crate) struct MitJsonWriter;

impl RecordingWriter for MitJsonWriter {
    fn id(&self) -> &'static str {
        "mit-json"
    }

    fn format(&self) -> &'static str {
        "mit-json"
    }

    fn write(&self, recording: &Recording, dir: &Path) -> Result<PathBuf, DatasetError> {
        let path = dir.join(format!("{}.json", recording.name));
        let streams = samples(recording, &path, self.id())?;
        make_dir(dir)?;
        let sets = streams.iter().map(|(role, samples)| {
            let rows = samples.iter().fold(String::new(), |mut rows, sample| {
                let separator = if rows.is_empty() { "" } else { "," };
                let [a, b, c] = sample.values;
                // Writing to a string cannot fail.
                let _ = write!(rows, "{separator}\n[{}, {a}, {b}, {c}]", sample.seconds());
                rows
            });
            format!("\"{}\": [{rows}]", default_data_set(*role))
        });
        let text = format!("{{{}}}\n", sets.collect::<Vec<_>>().join(",\n"));
        output::write(&path, text)?;
        Ok(path)
    }
}
