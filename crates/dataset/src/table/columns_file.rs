//! Columns of a caller's own as a CSV or Parquet file, with their provenance.

use std::io::Write;

use output::OutputFile;
use tempfile::NamedTempFile;

use crate::error::DatasetError;
use crate::table::Provenance;
use crate::table::kind::{Kind, extension};
use crate::table::named_column::NamedColumn;

/// Writes columns of the same length as CSV (`.csv`, standard output) or Parquet (`.parquet`, feature
/// `parquet`).
///
/// # Errors
/// `Io`, `Output` or `Parquet` if the file cannot be written; `Unwritable` for another extension or columns
/// of different lengths; `FeatureOff` for Parquet without its feature.
pub fn write_columns(
    output: OutputFile,
    columns: &[NamedColumn],
    provenance: &Provenance,
) -> Result<(), DatasetError> {
    let n_rows = columns.first().map_or(0, |column| column.cells.len());
    if let Some(other) = columns.iter().find(|column| column.cells.len() != n_rows) {
        let (name, n) = (&other.name, other.cells.len());
        let what = format!("column {name} has {n} rows where the first one has {n_rows}");
        return Err(DatasetError::Unwritable { path: output.path().into(), format: "table", what });
    }
    let kind = match output.is_standard_output() {
        true => Kind::Csv,
        false => extension(output.path())?,
    };
    let part = match kind {
        Kind::Csv => as_csv(&output, n_rows, columns, provenance)?,
        Kind::Parquet => as_parquet(&output, columns, provenance)?,
    };
    Ok(output.finish(part)?)
}

fn as_csv(
    output: &OutputFile,
    n_rows: usize,
    columns: &[NamedColumn],
    provenance: &Provenance,
) -> Result<NamedTempFile, DatasetError> {
    let mut part = output.begin()?;
    let write = || -> std::io::Result<NamedTempFile> {
        for (key, value) in &provenance.entries {
            writeln!(part, "# {key}: {value}")?;
        }
        let mut writer = csv::Writer::from_writer(part);
        writer.write_record(columns.iter().map(|column| &column.name))?;
        for row in 0..n_rows {
            writer.write_record(columns.iter().map(|column| column.cells.text(row)))?;
        }
        writer.into_inner().map_err(csv::IntoInnerError::into_error)
    };
    write().map_err(|error| DatasetError::io("write", output.path(), error))
}

#[cfg(feature = "parquet")]
fn as_parquet(
    output: &OutputFile,
    columns: &[NamedColumn],
    provenance: &Provenance,
) -> Result<NamedTempFile, DatasetError> {
    let part = output.begin()?;
    let file = part.as_file().try_clone();
    let file = file.map_err(|error| DatasetError::io("write", output.path(), error))?;
    let written = crate::table::parquet::write_named(file, columns, provenance);
    written.map_err(|error| DatasetError::Parquet {
        path: output.path().into(),
        what: error.to_string(),
    })?;
    Ok(part)
}

#[cfg(not(feature = "parquet"))]
fn as_parquet(
    _: &OutputFile,
    _: &[NamedColumn],
    _: &Provenance,
) -> Result<NamedTempFile, DatasetError> {
    Err(DatasetError::FeatureOff { what: "writing Parquet", feature: "parquet" })
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use output::{Existing, OutputFile};

    use super::write_columns;
    use crate::table::Provenance;
    use crate::table::named_column::{Cells, NamedColumn};

    fn columns() -> Vec<NamedColumn> {
        let column = |name: &str, cells| NamedColumn { name: name.to_owned(), cells };
        vec![
            column("recording", Cells::Text(vec!["a,b".to_owned(), String::new()])),
            column("step", Cells::Integer(vec![0, 1])),
            column("dx_m", Cells::Real(vec![Some(0.1 + 0.2), None])),
        ]
    }

    fn written(path: &Path, columns: &[NamedColumn]) -> Result<(), String> {
        let mut provenance = Provenance::default();
        provenance.push("tool", "test");
        let output = OutputFile::new(path, Existing::Replace).unwrap();
        write_columns(output, columns, &provenance).map_err(|error| error.to_string())
    }

    #[test]
    fn what_is_missing_leaves_an_empty_cell() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("columns.csv");
        written(&path, &columns()).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        let expected = "# tool: test\nrecording,step,dx_m\n\"a,b\",0,0.30000000000000004\n,1,\n";
        assert_eq!(text, expected);
    }

    #[test]
    fn columns_of_different_lengths_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let mut columns = columns();
        columns[2].cells = Cells::Real(vec![None]);
        let error = written(&folder.path().join("columns.csv"), &columns).unwrap_err();
        assert!(error.contains("column dx_m has 1 rows where the first one has 2"), "{error}");
        let error = written(&folder.path().join("columns.txt"), &columns[..2]).unwrap_err();
        assert!(error.contains("tables end in .csv or .parquet"), "{error}");
    }

    #[cfg(feature = "parquet")]
    #[test]
    fn columns_come_back_from_parquet_bit_for_bit() {
        use parquet::file::reader::{FileReader, SerializedFileReader};
        use parquet::record::RowAccessor;

        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("columns.parquet");
        written(&path, &columns()).unwrap();
        let reader = SerializedFileReader::new(std::fs::File::open(&path).unwrap()).unwrap();
        let rows: Vec<_> = reader.get_row_iter(None).unwrap().map(Result::unwrap).collect();
        assert_eq!(rows[0].get_string(0).unwrap(), "a,b");
        assert_eq!([0, 1].map(|k| rows[k].get_uint(1).unwrap()), [0, 1]);
        assert_eq!(rows[0].get_double(2).unwrap().to_bits(), (0.1_f64 + 0.2).to_bits());
        assert!(rows[1].get_double(2).is_err());
        let tool = reader.metadata().file_metadata().key_value_metadata().unwrap();
        assert!(tool.iter().any(|pair| pair.key == "tool"));
    }
}
