//! The step table as Parquet, by the low-level column writer; provenance is in the key-value
//! metadata.

use std::{fs::File, path::Path, sync::Arc};

use parquet::{
    basic::{Compression, LogicalType, Repetition, Type as PhysicalType},
    column::{reader::ColumnReader, writer::ColumnWriter},
    data_type::ByteArray,
    errors::ParquetError,
    file::{
        metadata::KeyValue,
        properties::WriterProperties,
        reader::{FileReader, RowGroupReader, SerializedFileReader},
        writer::SerializedFileWriter,
    },
    schema::types::Type,
};

use crate::{
    column::{Access, Column, columns},
    error::DatasetError,
    step::StepRow,
    table::{Provenance, Table},
    table_csv::NameCache,
};

const ROWS_PER_GROUP: usize = 65_536;

pub(crate) fn write(table: &Table, path: &Path) -> Result<(), DatasetError> {
    let file = File::create(path).map_err(|error| DatasetError::io("write", path, error))?;
    write_rows(table, file).map_err(|error| failure(path, &error))
}

pub(crate) fn read(path: &Path) -> Result<Table, DatasetError> {
    let file = File::open(path).map_err(|error| DatasetError::io("read", path, error))?;
    let reader = SerializedFileReader::new(file).map_err(|error| failure(path, &error))?;
    let metadata = reader.metadata().file_metadata();
    let mut provenance = Provenance::default();
    for pair in metadata.key_value_metadata().into_iter().flatten() {
        // Keys were numbered, since the format does not promise to keep equal ones.
        if let Some((_, key)) = pair.key.split_once(' ') {
            provenance.push(key, pair.value.as_deref().unwrap_or_default());
        }
    }
    let schema = metadata.schema_descr();
    let found: Vec<_> = schema.columns().iter().map(|c| c.name().to_owned()).collect();
    let mut rows = Vec::new();
    let mut names = NameCache::default();
    for group in 0..reader.num_row_groups() {
        let group = reader.get_row_group(group).map_err(|error| failure(path, &error))?;
        let n_rows = usize::try_from(group.metadata().num_rows()).unwrap_or(0);
        let mut part = vec![StepRow::default(); n_rows];
        for column in columns() {
            let place = found.iter().position(|name| name == column.name).ok_or_else(|| {
                DatasetError::ColumnMissing {
                    path: path.into(),
                    column: column.name.into(),
                    found: found.join(", "),
                }
            })?;
            read_column(&*group, place, column, &mut part)
                .map_err(|what| DatasetError::Parquet { path: path.into(), what })?;
        }
        part.iter_mut().for_each(|row| names.share(row));
        rows.append(&mut part);
    }
    Ok(Table { rows, provenance })
}

fn failure(path: &Path, error: &ParquetError) -> DatasetError {
    DatasetError::Parquet { path: path.into(), what: error.to_string() }
}

fn write_rows(table: &Table, file: File) -> Result<(), ParquetError> {
    let fields = columns().iter().map(|column| field(column).map(Arc::new));
    let schema = Type::group_type_builder("step")
        .with_fields(fields.collect::<Result<_, _>>()?)
        .build()?;
    let entries = table.provenance.entries.iter().enumerate();
    let pairs = entries
        .map(|(i, (key, value))| KeyValue::new(format!("{i:06} {key}"), value.clone()))
        .collect();
    let properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_created_by(crate::ingest::TOOL.to_owned())
        .set_key_value_metadata(Some(pairs))
        .build();
    let mut writer = SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties))?;
    for rows in table.rows.chunks(ROWS_PER_GROUP) {
        let mut group = writer.next_row_group()?;
        for column in columns() {
            let Some(mut out) = group.next_column()? else { break };
            write_column(column, rows, out.untyped())?;
            out.close()?;
        }
        group.close()?;
    }
    writer.close()?;
    Ok(())
}

fn field(column: &Column) -> Result<Type, ParquetError> {
    let (physical, logical, repetition) = match column.access {
        Access::Text(..) => {
            (PhysicalType::BYTE_ARRAY, Some(LogicalType::String), Repetition::OPTIONAL)
        }
        Access::Integer(..) => (PhysicalType::INT64, None, Repetition::REQUIRED),
        Access::Real(..) => (PhysicalType::DOUBLE, None, Repetition::REQUIRED),
        Access::OptionalReal(..) => (PhysicalType::DOUBLE, None, Repetition::OPTIONAL),
    };
    Type::primitive_type_builder(column.name, physical)
        .with_logical_type(logical)
        .with_repetition(repetition)
        .build()
}

fn write_column(
    column: &Column,
    rows: &[StepRow],
    out: &mut ColumnWriter<'_>,
) -> Result<(), ParquetError> {
    match (&column.access, out) {
        (Access::Text(get, _), ColumnWriter::ByteArrayColumnWriter(out)) => {
            let cells: Vec<_> = rows.iter().map(get).collect();
            let levels: Vec<_> = cells.iter().map(|cell| i16::from(cell.is_some())).collect();
            let values: Vec<_> =
                cells.iter().flatten().map(|text| ByteArray::from(text.as_str())).collect();
            out.write_batch(&values, Some(&levels), None)?;
        }
        (Access::Integer(get, _), ColumnWriter::Int64ColumnWriter(out)) => {
            let values: Vec<_> = rows.iter().map(|row| i64::from(get(row))).collect();
            out.write_batch(&values, None, None)?;
        }
        (Access::Real(get, _), ColumnWriter::DoubleColumnWriter(out)) => {
            let values: Vec<_> = rows.iter().map(get).collect();
            out.write_batch(&values, None, None)?;
        }
        (Access::OptionalReal(get, _), ColumnWriter::DoubleColumnWriter(out)) => {
            let cells: Vec<_> = rows.iter().map(get).collect();
            let levels: Vec<_> = cells.iter().map(|cell| i16::from(cell.is_some())).collect();
            let values: Vec<_> = cells.into_iter().flatten().collect();
            out.write_batch(&values, Some(&levels), None)?;
        }
        _ => return Err(ParquetError::General(format!("{} has another type", column.name))),
    }
    Ok(())
}

fn read_column(
    group: &dyn RowGroupReader,
    place: usize,
    column: &Column,
    rows: &mut [StepRow],
) -> Result<(), String> {
    let fail = |error: ParquetError| error.to_string();
    let n = rows.len();
    let mut levels = Vec::new();
    match (&column.access, group.get_column_reader(place).map_err(fail)?) {
        (Access::Text(_, set), ColumnReader::ByteArrayColumnReader(mut reader)) => {
            let mut values = Vec::new();
            reader.read_records(n, Some(&mut levels), None, &mut values).map_err(fail)?;
            let mut values = values.into_iter();
            for (row, _) in rows.iter_mut().zip(&levels).filter(|(_, level)| **level == 1) {
                let value = values.next().unwrap_or_default();
                let text = value.as_utf8().map_err(fail)?;
                set(row, text).map_err(|e| format!("{} is `{text}`, expected {e}", column.name))?;
            }
        }
        (Access::Integer(_, set), ColumnReader::Int64ColumnReader(mut reader)) => {
            let mut values = Vec::new();
            reader.read_records(n, None, None, &mut values).map_err(fail)?;
            for (row, value) in rows.iter_mut().zip(values) {
                let value = u32::try_from(value);
                set(row, value.map_err(|_| format!("{} is no whole number from 0", column.name))?);
            }
        }
        (Access::Real(_, set), ColumnReader::DoubleColumnReader(mut reader)) => {
            let mut values = Vec::new();
            reader.read_records(n, None, None, &mut values).map_err(fail)?;
            for (row, value) in rows.iter_mut().zip(values) {
                set(row, finite(column, value)?);
            }
        }
        (Access::OptionalReal(_, set), ColumnReader::DoubleColumnReader(mut reader)) => {
            let mut values = Vec::new();
            reader.read_records(n, Some(&mut levels), None, &mut values).map_err(fail)?;
            let present = rows.iter_mut().zip(&levels).filter(|(_, level)| **level == 1);
            for ((row, _), value) in present.zip(values) {
                set(row, finite(column, value)?);
            }
        }
        _ => return Err(format!("column {} has another type than ours", column.name)),
    }
    Ok(())
}

fn finite(column: &Column, value: f64) -> Result<f64, String> {
    if value.is_finite() {
        Ok(value)
    } else {
        Err(format!("{} is {value}, expected a finite number in {}", column.name, column.unit))
    }
}
