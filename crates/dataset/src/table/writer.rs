//! A step table written row by row, whole or not there at its end.

use std::path::Path;

use output::{Existing, OutputFile};

use crate::error::DatasetError;
use crate::table::Provenance;
use crate::table::csv::RowsFile;
use crate::table::kind::{Kind, extension};
use crate::table::step::StepRow;

/// Writes a table as its rows come, in memory that does not grow with their number.
///
/// Everything is under temporary names beside the table until [`Self::finish`]; a writer that is
/// dropped before removes them.
pub struct TableWriter {
    output: OutputFile,
    rows: Rows,
    /// Whether there are whole pushes, once the first row is there.
    is_of_whole_pushes: Option<bool>,
}

enum Rows {
    Csv(Box<RowsFile>),
    #[cfg(feature = "parquet")]
    Parquet(Box<crate::table::parquet::GroupWriter>),
}

impl TableWriter {
    /// Begins a table as CSV (`.csv`) or Parquet (`.parquet`, feature `parquet`), in place of one
    /// that is there.
    ///
    /// # Errors
    /// `Output` if nothing can be written there, and as [`Self::begin`].
    pub fn create(path: &Path) -> Result<Self, DatasetError> {
        extension(path)?;
        Self::begin(OutputFile::new(path, Existing::Replace)?)
    }

    /// Begins a table whose place is taken; on standard output it is CSV.
    ///
    /// # Errors
    /// `Output` if nothing can be written there, `Unwritable` for another extension than `.csv` and
    /// `.parquet`, `FeatureOff` for Parquet without its feature.
    pub fn begin(output: OutputFile) -> Result<Self, DatasetError> {
        let kind = match output.is_standard_output() {
            true => Kind::Csv,
            false => extension(output.path())?,
        };
        let rows = match kind {
            Kind::Csv => Rows::Csv(Box::new(RowsFile::begin(&output)?)),
            Kind::Parquet => parquet_rows(&output)?,
        };
        Ok(Self { output, rows, is_of_whole_pushes: None })
    }

    /// Appends a row.
    ///
    /// # Errors
    /// `Io` or `Parquet` if the file cannot be written; `Unwritable` for whole pushes and other steps
    /// in one table.
    pub fn write(&mut self, row: &StepRow) -> Result<(), DatasetError> {
        let is_whole = row.is_whole_push();
        if *self.is_of_whole_pushes.get_or_insert(is_whole) != is_whole {
            let what = "whole pushes and other steps are not for one table; write one of each";
            let (path, what) = (self.output.path().into(), what.to_owned());
            return Err(DatasetError::Unwritable { path, format: "table", what });
        }
        match &mut self.rows {
            Rows::Csv(rows) => rows.write(row),
            #[cfg(feature = "parquet")]
            Rows::Parquet(groups) => groups.write(row.clone()),
        }
    }

    /// Adds the provenance and gives the table its name.
    ///
    /// # Errors
    /// `Io`, `Output` or `Parquet` if the file cannot be written.
    pub fn finish(self, provenance: &Provenance) -> Result<(), DatasetError> {
        let part = match self.rows {
            Rows::Csv(rows) => rows.finish(provenance, self.output.begin()?)?,
            #[cfg(feature = "parquet")]
            Rows::Parquet(groups) => groups.finish(provenance)?,
        };
        Ok(self.output.finish(part)?)
    }
}

#[cfg(feature = "parquet")]
fn parquet_rows(output: &OutputFile) -> Result<Rows, DatasetError> {
    let groups = crate::table::parquet::GroupWriter::create(output.path(), output.begin()?)?;
    Ok(Rows::Parquet(Box::new(groups)))
}

#[cfg(not(feature = "parquet"))]
fn parquet_rows(_: &OutputFile) -> Result<Rows, DatasetError> {
    Err(DatasetError::FeatureOff { what: "writing Parquet", feature: "parquet" })
}

#[cfg(test)]
mod tests {
    use std::{fs, path::Path};

    use super::TableWriter;
    use crate::table::step::StepRow;
    use crate::table::{Provenance, Table};

    fn table(n_rows: u32) -> Table {
        let rows = (0..n_rows).map(|i| StepRow {
            recording: "push".into(),
            step: i,
            dx: f64::from(i) / 3.0,
            ..StepRow::default()
        });
        let mut provenance = Provenance::default();
        provenance.push("tool", "test");
        Table { rows: rows.collect(), provenance }
    }

    fn files(dir: &Path) -> Vec<String> {
        let entries = fs::read_dir(dir).unwrap();
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
    }

    fn endings() -> impl Iterator<Item = &'static str> {
        ["csv"].into_iter().chain(cfg!(feature = "parquet").then_some("parquet"))
    }

    #[test]
    fn rows_one_by_one_give_the_file_of_the_whole_table() {
        // More rows than a row group of Parquet has.
        let table = table(70_000);
        for ending in endings() {
            let dir = tempfile::tempdir().unwrap();
            let (whole, streamed) = (dir.path().join("a"), dir.path().join("b"));
            let (whole, streamed) = (whole.with_extension(ending), streamed.with_extension(ending));
            table.write(&whole).unwrap();
            let mut writer = TableWriter::create(&streamed).unwrap();
            for row in &table.rows {
                writer.write(row).unwrap();
            }
            assert!(!streamed.exists());
            writer.finish(&table.provenance).unwrap();
            assert!(fs::read(&whole).unwrap() == fs::read(&streamed).unwrap());
            assert_eq!(files(dir.path()).len(), 2);
            assert_eq!(Table::read(&streamed).unwrap(), table);
        }
    }

    #[test]
    fn a_writer_given_up_leaves_nothing_and_spares_what_was_there() {
        for ending in endings() {
            let dir = tempfile::tempdir().unwrap();
            let path = dir.path().join("table").with_extension(ending);
            table(2).write(&path).unwrap();
            let before = fs::read(&path).unwrap();
            let mut writer = TableWriter::create(&path).unwrap();
            writer.write(&StepRow::default()).unwrap();
            drop(writer);
            assert_eq!(files(dir.path()), [path.file_name().unwrap().to_str().unwrap()]);
            assert!(fs::read(&path).unwrap() == before);
        }
    }

    #[test]
    fn a_name_that_cannot_be_taken_leaves_nothing_beside_it() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("table.csv");
        fs::create_dir(&path).unwrap();
        assert!(table(2).write(&path).is_err());
        assert_eq!(files(dir.path()), ["table.csv"]);
    }
}
