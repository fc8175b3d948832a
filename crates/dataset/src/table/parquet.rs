//! The step table as Parquet, with its provenance as key-value metadata of the file.

use std::{
    fs::File,
    path::{Path, PathBuf},
    sync::Arc,
};

use parquet::{
    basic::{Compression, ConvertedType, Repetition, Type as PhysicalType},
    data_type::{ByteArray, ByteArrayType, DoubleType, Int32Type},
    errors::ParquetError,
    file::{
        metadata::KeyValue,
        properties::WriterProperties,
        writer::{SerializedColumnWriter, SerializedFileWriter, SerializedRowGroupWriter},
    },
    schema::types::Type,
};
use tempfile::NamedTempFile;

use crate::error::DatasetError;
use crate::table::Provenance;
use crate::table::column::{Access, Column, written_columns};
use crate::table::named_column::{Cells, NamedColumn};
use crate::table::step::StepRow;

/// Rows that share a row group: as many are in memory while writing.
const GROUP: usize = 65_536;

/// Writes row groups as they fill; the provenance goes to the end of the file.
pub(crate) struct GroupWriter {
    /// Of the table, for messages.
    path: PathBuf,
    part: NamedTempFile,
    /// With its columns, which the first rows decide.
    writer: Option<(SerializedFileWriter<File>, Vec<&'static Column>)>,
    rows: Vec<StepRow>,
}

impl GroupWriter {
    pub(crate) fn create(path: &Path, part: NamedTempFile) -> Result<Self, DatasetError> {
        Ok(Self { path: path.into(), part, writer: None, rows: Vec::new() })
    }

    pub(crate) fn write(&mut self, row: StepRow) -> Result<(), DatasetError> {
        self.rows.push(row);
        if self.rows.len() == GROUP { self.write_group() } else { Ok(()) }
    }

    pub(crate) fn finish(mut self, provenance: &Provenance) -> Result<NamedTempFile, DatasetError> {
        if !self.rows.is_empty() {
            self.write_group()?;
        }
        let (mut writer, _) = self.begun()?;
        for (key, value) in &provenance.entries {
            writer.append_key_value_metadata(KeyValue::new(key.clone(), value.clone()));
        }
        writer.close().map_err(|error| unusable(&self.path, error))?;
        Ok(self.part)
    }

    fn write_group(&mut self) -> Result<(), DatasetError> {
        let (mut writer, columns) = self.begun()?;
        let mut write = || {
            let mut group = writer.next_row_group()?;
            for column in &columns {
                write_column(&mut group, column, &self.rows)?;
            }
            group.close()
        };
        write().map_err(|error| unusable(&self.path, error))?;
        self.writer = Some((writer, columns));
        self.rows.clear();
        Ok(())
    }

    /// The file with its columns, to be put back for more rows.
    fn begun(
        &mut self,
    ) -> Result<(SerializedFileWriter<File>, Vec<&'static Column>), DatasetError> {
        if let Some(begun) = self.writer.take() {
            return Ok(begun);
        }
        let file = self.part.as_file().try_clone();
        let file = file.map_err(|error| DatasetError::io("write", &self.path, error))?;
        let has_way = self.rows.first().is_some_and(StepRow::is_whole_push);
        let columns: Vec<_> = written_columns(has_way).collect();
        let writer = file_writer(file, &columns).map_err(|error| unusable(&self.path, error))?;
        Ok((writer, columns))
    }
}

fn unusable(path: &Path, error: impl ToString) -> DatasetError {
    DatasetError::Parquet { path: path.into(), what: error.to_string() }
}

/// Writes columns of a caller's own, in one row group.
pub(crate) fn write_named(
    file: File,
    columns: &[NamedColumn],
    provenance: &Provenance,
) -> Result<(), ParquetError> {
    let fields = columns.iter().map(|column| {
        let kind = match column.cells {
            Cells::Text(_) => TEXT,
            Cells::Integer(_) => INTEGER,
            Cells::Real(_) => OPTIONAL_REAL,
        };
        field(&column.name, kind)
    });
    let mut writer = writer_of(file, fields.collect::<Result<_, _>>()?)?;
    let mut group = writer.next_row_group()?;
    for NamedColumn { name, cells } in columns {
        match cells {
            Cells::Text(cells) => {
                write_text(&mut group, name, &cells.iter().map(Some).collect::<Vec<_>>())?;
            }
            Cells::Integer(cells) => {
                write_integers(&mut group, name, cells.iter().copied())?;
            }
            Cells::Real(cells) => write_optional(&mut group, name, cells)?,
        }
    }
    group.close()?;
    for (key, value) in &provenance.entries {
        writer.append_key_value_metadata(KeyValue::new(key.clone(), value.clone()));
    }
    writer.close().map(|_| ())
}

fn file_writer(
    file: File,
    columns: &[&Column],
) -> Result<SerializedFileWriter<File>, ParquetError> {
    let fields = columns.iter().map(|column| {
        let kind = match column.access {
            Access::Text(..) => TEXT,
            Access::Integer(..) => INTEGER,
            Access::Real(..) => REAL,
            Access::OptionalReal(..) => OPTIONAL_REAL,
        };
        field(column.name, kind)
    });
    writer_of(file, fields.collect::<Result<_, _>>()?)
}

fn writer_of(
    file: File,
    fields: Vec<Arc<Type>>,
) -> Result<SerializedFileWriter<File>, ParquetError> {
    let properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_key_value_metadata(Some(Vec::new()))
        .build();
    let schema = Type::group_type_builder("steps").with_fields(fields).build()?;
    SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties))
}

/// How a column is stored.
type FieldKind = (PhysicalType, ConvertedType, Repetition);

const TEXT: FieldKind = (PhysicalType::BYTE_ARRAY, ConvertedType::UTF8, Repetition::OPTIONAL);
const INTEGER: FieldKind = (PhysicalType::INT32, ConvertedType::UINT_32, Repetition::REQUIRED);
const REAL: FieldKind = (PhysicalType::DOUBLE, ConvertedType::NONE, Repetition::REQUIRED);
const OPTIONAL_REAL: FieldKind = (PhysicalType::DOUBLE, ConvertedType::NONE, Repetition::OPTIONAL);

fn field(
    name: &str,
    (physical, converted, repetition): FieldKind,
) -> Result<Arc<Type>, ParquetError> {
    let builder = Type::primitive_type_builder(name, physical);
    builder.with_converted_type(converted).with_repetition(repetition).build().map(Arc::new)
}

fn write_column(
    group: &mut SerializedRowGroupWriter<'_, File>,
    column: &Column,
    rows: &[StepRow],
) -> Result<(), ParquetError> {
    match &column.access {
        Access::Text(get, _) => {
            write_text(group, column.name, &rows.iter().map(get).collect::<Vec<_>>())
        }
        Access::Integer(get, _) => write_integers(group, column.name, rows.iter().map(get)),
        Access::Real(get, _) => {
            let values: Vec<_> = rows.iter().map(get).collect();
            let mut writer = next_column(group, column.name)?;
            writer.typed::<DoubleType>().write_batch(&values, None, None)?;
            writer.close()
        }
        Access::OptionalReal(get, _) => {
            write_optional(group, column.name, &rows.iter().map(get).collect::<Vec<_>>())
        }
    }
}

fn next_column<'a>(
    group: &'a mut SerializedRowGroupWriter<'_, File>,
    name: &str,
) -> Result<SerializedColumnWriter<'a>, ParquetError> {
    let missing = || ParquetError::General(format!("no room for column {name}"));
    group.next_column()?.ok_or_else(missing)
}

fn write_text<T: AsRef<str>>(
    group: &mut SerializedRowGroupWriter<'_, File>,
    name: &str,
    cells: &[Option<T>],
) -> Result<(), ParquetError> {
    let mut writer = next_column(group, name)?;
    let values: Vec<_> =
        cells.iter().flatten().map(|text| ByteArray::from(text.as_ref())).collect();
    writer.typed::<ByteArrayType>().write_batch(&values, Some(&levels(cells)), None)?;
    writer.close()
}

fn write_integers(
    group: &mut SerializedRowGroupWriter<'_, File>,
    name: &str,
    cells: impl Iterator<Item = u32>,
) -> Result<(), ParquetError> {
    let mut writer = next_column(group, name)?;
    let values: Vec<_> = cells.map(u32::cast_signed).collect();
    writer.typed::<Int32Type>().write_batch(&values, None, None)?;
    writer.close()
}

fn write_optional(
    group: &mut SerializedRowGroupWriter<'_, File>,
    name: &str,
    cells: &[Option<f64>],
) -> Result<(), ParquetError> {
    let mut writer = next_column(group, name)?;
    let values: Vec<_> = cells.iter().copied().flatten().collect();
    writer.typed::<DoubleType>().write_batch(&values, Some(&levels(cells)), None)?;
    writer.close()
}

/// 1 where there is a value.
fn levels<T>(cells: &[Option<T>]) -> Vec<i16> {
    cells.iter().map(|cell| cell.is_some().into()).collect()
}

#[cfg(test)]
mod tests {
    use super::{Provenance, StepRow};
    use crate::error::DatasetError;
    use crate::table::Table;
    use crate::table::step::{ContactForce, StepForce};

    fn table() -> Table {
        let mut provenance = Provenance::default();
        provenance.push("tool", "pushlab test");
        provenance.push("source", "0f3a push-0000");
        let plain = StepRow { recording: "a".into(), shape: "rect1".into(), ..StepRow::default() };
        let half = ContactForce { normal: 0.1 + 0.2, tangential: -1.0 / 3.0 };
        let force = Some(StepForce { mean: half, start: half, end: half });
        let full = StepRow {
            session: Some("morning".into()),
            push: 3,
            p: f64::MIN_POSITIVE,
            force,
            ..plain.clone()
        };
        Table { rows: vec![plain, full], provenance }
    }

    #[test]
    fn a_table_comes_back_from_parquet_bit_for_bit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.parquet");
        table().write(&path).unwrap();
        assert_eq!(Table::read(&path).unwrap(), table());
    }

    #[test]
    fn a_file_that_is_not_parquet_is_refused_with_its_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.parquet");
        std::fs::write(&path, "p,beta_rad\n0.5,0.1\n").unwrap();
        let error = Table::read(&path).unwrap_err();
        assert!(matches!(error, DatasetError::Parquet { .. }), "{error}");
        assert!(error.to_string().contains("table.parquet"), "{error}");
    }
}
