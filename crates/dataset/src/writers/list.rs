//! The list of all writers of recordings.

use crate::RecordingWriter;
#[cfg(feature = "bag")]
use crate::writers::BagWriter;
#[cfg(feature = "hdf5")]
use crate::writers::MitHdf5Writer;
use crate::writers::{CsvWriter, McapWriter, MitJsonWriter};

/// Every writer of this build.
#[must_use]
pub fn all_writers() -> &'static [&'static dyn RecordingWriter] {
    &[
        &CsvWriter,
        &McapWriter::ROS2,
        &McapWriter::ROS1,
        &McapWriter::JSON,
        #[cfg(feature = "protobuf")]
        &McapWriter::PROTOBUF,
        &MitJsonWriter,
        #[cfg(feature = "hdf5")]
        &MitHdf5Writer,
        #[cfg(feature = "bag")]
        &BagWriter,
    ]
}

#[cfg(test)]
mod tests;
