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
        writer::{SerializedFileWriter, SerializedRowGroupWriter},
    },
    schema::types::Type,
};
use tempfile::NamedTempFile;

use crate::error::DatasetError;
use crate::table::Provenance;
use crate::table::column::{Access, Column, written_columns};
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

fn file_writer(
    file: File,
    columns: &[&Column],
) -> Result<SerializedFileWriter<File>, ParquetError> {
    let properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_key_value_metadata(Some(Vec::new()))
        .build();
    let fields = columns.iter().map(|column| field(column)).collect::<Result<Vec<_>, _>>()?;
    let schema = Type::group_type_builder("steps").with_fields(fields).build()?;
    SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties))
}

fn field(column: &Column) -> Result<Arc<Type>, ParquetError> {
    let (physical, converted, repetition) = match column.access {
        Access::Text(..) => (PhysicalType::BYTE_ARRAY, ConvertedType::UTF8, Repetition::OPTIONAL),
        Access::Integer(..) => (PhysicalType::INT32, ConvertedType::UINT_32, Repetition::REQUIRED),
        Access::Real(..) => (PhysicalType::DOUBLE, ConvertedType::NONE, Repetition::REQUIRED),
        Access::OptionalReal(..) => {
            (PhysicalType::DOUBLE, ConvertedType::NONE, Repetition::OPTIONAL)
        }
    };
    let builder = Type::primitive_type_builder(column.name, physical);
    builder.with_converted_type(converted).with_repetition(repetition).build().map(Arc::new)
}

fn write_column(
    group: &mut SerializedRowGroupWriter<'_, File>,
    column: &Column,
    rows: &[StepRow],
) -> Result<(), ParquetError> {
    let missing = || ParquetError::General(format!("no room for column {}", column.name));
    let mut writer = group.next_column()?.ok_or_else(missing)?;
    match &column.access {
        Access::Text(get, _) => {
            let cells: Vec<_> = rows.iter().map(get).collect();
            let levels: Vec<i16> = cells.iter().map(|cell| cell.is_some().into()).collect();
            let values: Vec<_> =
                cells.iter().flatten().map(|text| ByteArray::from(text.as_str())).collect();
            writer.typed::<ByteArrayType>().write_batch(&values, Some(&levels), None)?;
        }
        Access::Integer(get, _) => {
            let values: Vec<_> = rows.iter().map(|row| get(row).cast_signed()).collect();
            writer.typed::<Int32Type>().write_batch(&values, None, None)?;
        }
        Access::Real(get, _) => {
            let values: Vec<_> = rows.iter().map(get).collect();
            writer.typed::<DoubleType>().write_batch(&values, None, None)?;
        }
        Access::OptionalReal(get, _) => {
            let cells: Vec<_> = rows.iter().map(get).collect();
            let levels: Vec<i16> = cells.iter().map(|cell| cell.is_some().into()).collect();
            let values: Vec<_> = cells.into_iter().flatten().collect();
            writer.typed::<DoubleType>().write_batch(&values, Some(&levels), None)?;
        }
    }
    writer.close()
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
