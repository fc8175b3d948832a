//! CSV folders, as the CSV format reads them.

use std::{
    fmt::Write as _,
    path::{Path, PathBuf},
};

use output::{Existing, OutputFolder};

use super::sample::samples;
use crate::recording::Recording;
use crate::writers::writer::{RecordingWriter, make_dir};
use crate::{error::DatasetError, remark::StreamRole};

/// Writes a folder with a CSV file a stream.
pub(crate) struct CsvWriter;

impl RecordingWriter for CsvWriter {
    fn id(&self) -> &'static str {
        "csv"
    }

    fn format(&self) -> &'static str {
        "csv"
    }

    fn write(&self, recording: &Recording, dir: &Path) -> Result<PathBuf, DatasetError> {
        let folder = dir.join(&recording.name);
        let streams = samples(recording, &folder, self.id())?;
        make_dir(dir)?;
        // Forces of an earlier recording of this name would be read as this one's: none of it stays.
        let output = OutputFolder::new(&folder, Existing::Replace)?;
        let part = output.begin()?;
        let with_torque = recording.wrench.as_ref().is_some_and(|stream| !stream.tz.is_empty());
        for (role, samples) in streams {
            let (mut text, decimals) = match role {
                StreamRole::Wrench if with_torque => ("t_s,fx_n,fy_n,tz_nm\n".to_owned(), 3),
                StreamRole::Wrench => ("t_s,fx_n,fy_n\n".to_owned(), 3),
                StreamRole::Robot | StreamRole::Object => ("t_s,x_m,y_m,theta_rad\n".to_owned(), 6),
            };
            for sample in samples {
                let [a, b, c] = sample.values;
                // Writing to a string cannot fail.
                let _ = write!(text, "{},{a:.decimals$},{b:.decimals$}", sample.seconds());
                let _ = match role {
                    StreamRole::Wrench if !with_torque => writeln!(text),
                    _ => writeln!(text, ",{c:.6}"),
                };
            }
            part.write(&format!("{role}.csv"), text)?;
        }
        output.finish(part)?;
        Ok(folder)
    }
}
