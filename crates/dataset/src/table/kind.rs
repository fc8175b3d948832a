//! The two forms of a table's file.

use std::path::Path;

use crate::error::DatasetError;

/// The two forms of a table's file.
pub(crate) enum Kind {
    Csv,
    Parquet,
}

/// The form that a path's ending asks for.
pub(crate) fn extension(path: &Path) -> Result<Kind, DatasetError> {
    match path.extension().and_then(|extension| extension.to_str()) {
        Some("csv") => Ok(Kind::Csv),
        Some("parquet") => Ok(Kind::Parquet),
        other => Err(DatasetError::Unwritable {
            path: path.into(),
            format: "table",
            what: format!(
                "tables end in .csv or .parquet, not .{}; rename it",
                other.unwrap_or_default()
            ),
        }),
    }
}
