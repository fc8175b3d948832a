//! A whole table to a file and back, by its ending.

use std::path::Path;

use crate::table::csv::read as read_csv;
use crate::table::kind::{Kind, extension};
use crate::table::writer::TableWriter;
use crate::{Table, error::DatasetError};

impl Table {
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
            Kind::Csv => read_csv(path)?,
            Kind::Parquet => read_parquet(path)?,
        };
        if table.len() < 2 {
            return Err(DatasetError::TableTooShort { path: path.into(), rows: table.len() });
        }
        Ok(table)
    }
}

#[cfg(feature = "parquet")]
use crate::table::parquet_read::read as read_parquet;

#[cfg(not(feature = "parquet"))]
fn read_parquet(_: &Path) -> Result<Table, DatasetError> {
    Err(DatasetError::FeatureOff { what: "reading Parquet", feature: "parquet" })
}
