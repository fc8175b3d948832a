//! The step table: rows with the record of what made them.

use std::path::Path;

use crate::{error::DatasetError, step::StepRow, table_csv, table_writer::TableWriter};

/// Steps of pushes, in the order of recordings, pushes and time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// One row a step.
    pub rows: Vec<StepRow>,
    /// What made the rows.
    pub provenance: Provenance,
}

/// What a table was made of and by what: pairs that every file of it carries.
///
/// Keys have no colon and no line break, values no line break; `source` occurs once a file, with
/// its SHA-256 and path.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Provenance {
    /// Keys and values, in the order of writing.
    pub entries: Vec<(String, String)>,
}

impl Provenance {
    /// Adds a pair; line breaks become spaces and colons of the key become dashes.
    pub fn push(&mut self, key: &str, value: &str) {
        let one_line = |text: &str| text.replace(['\r', '\n'], " ").trim().to_owned();
        self.entries.push((one_line(key).replace(':', "-"), one_line(value)));
    }

    /// The first value under a key.
    #[must_use]
    pub fn get(&self, key: &str) -> Option<&str> {
        self.entries.iter().find(|(known, _)| known == key).map(|(_, value)| value.as_str())
    }
}

impl Table {
    /// Number of rows.
    #[must_use]
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Whether there is no row.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Writes the table as CSV (`.csv`) or Parquet (`.parquet`, feature `parquet`), without loss.
    ///
    /// The file is written as by [`TableWriter`], to whom rows can also be given as they come.
    ///
    /// # Errors
    /// `Io` or `Output` if the file cannot be written, `Unwritable` for another extension,
    /// `FeatureOff` for Parquet without its feature.
    pub fn write(&self, path: &Path) -> Result<(), DatasetError> {
        let mut writer = TableWriter::create(path)?;
        for row in &self.rows {
            writer.write(row)?;
        }
        writer.finish(&self.provenance)
    }

    /// Reads a table that [`Table::write`] wrote, or one with the same columns in any order.
    ///
    /// # Errors
    /// `Io`, `ColumnMissing`, `Parse` with the line for a value that does not fit its column,
    /// `TableTooShort` for fewer than two rows.
    pub fn read(path: &Path) -> Result<Self, DatasetError> {
        let table = match extension(path)? {
            Kind::Csv => table_csv::read(path)?,
            Kind::Parquet => read_parquet(path)?,
        };
        if table.len() < 2 {
            return Err(DatasetError::TableTooShort { path: path.into(), rows: table.len() });
        }
        Ok(table)
    }
}

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

#[cfg(feature = "parquet")]
use crate::parquet_read::read as read_parquet;

#[cfg(not(feature = "parquet"))]
fn read_parquet(_: &Path) -> Result<Table, DatasetError> {
    Err(DatasetError::FeatureOff { what: "reading Parquet", feature: "parquet" })
}
