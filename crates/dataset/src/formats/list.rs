//! The list of all log formats.

#[cfg(feature = "bag")]
use crate::formats::BagFormat;
#[cfg(feature = "hdf5")]
use crate::formats::MitHdf5Format;
use crate::formats::{CsvFormat, EndPointsFormat, McapFormat, MitJsonFormat};
use crate::{LogFormat, error::DatasetError};

/// Every log format of this build.
#[must_use]
pub fn all_formats() -> &'static [&'static dyn LogFormat] {
    &[
        &McapFormat,
        &CsvFormat,
        &MitJsonFormat,
        #[cfg(feature = "hdf5")]
        &MitHdf5Format,
        #[cfg(feature = "bag")]
        &BagFormat,
        &EndPointsFormat,
    ]
}

/// The format with this name.
///
/// # Errors
/// `UnknownFormat` if there is none, `FeatureOff` if this build leaves it out.
pub fn format_by_id(id: &str) -> Result<&'static dyn LogFormat, DatasetError> {
    if let Some(format) = all_formats().iter().find(|format| format.id() == id) {
        return Ok(*format);
    }
    match id {
        "mit-hdf5" => Err(DatasetError::FeatureOff { what: "format mit-hdf5", feature: "hdf5" }),
        "ros1-bag" => Err(DatasetError::FeatureOff { what: "format ros1-bag", feature: "bag" }),
        _ => Err(DatasetError::UnknownFormat {
            id: id.into(),
            known: all_formats().iter().map(|format| format.id()).collect::<Vec<_>>().join(", "),
        }),
    }
}
