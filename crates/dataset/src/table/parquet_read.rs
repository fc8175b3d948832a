//! The step table from Parquet: a file is checked before its library reads it, column by column.

use std::path::Path;

use bytes::Bytes;
use parquet::{
    basic::{Compression, ConvertedType, Type as PhysicalType},
    column::reader::{ColumnReader, get_typed_column_reader},
    data_type::{ByteArray, ByteArrayType, DataType, DoubleType, Int32Type},
    errors::ParquetError,
    file::{
        metadata::{ColumnChunkMetaData, ParquetMetaData, RowGroupMetaData},
        reader::{FileReader, RowGroupReader, SerializedFileReader},
    },
    schema::types::ColumnDescriptor,
};

use crate::error::DatasetError;
use crate::input::caught::caught;
use crate::input::limits::{Limit, ReadLimits};
use crate::input::map::FileBytes;
use crate::table::column::{Access, Column, column_places};
use crate::table::csv::NameCache;
use crate::table::parquet_pages::{Chunk, check_pages};
use crate::table::step::StepRow;
use crate::table::{Provenance, Table};

/// Reads a table from a Parquet file.
pub(crate) fn read(path: &Path) -> Result<Table, DatasetError> {
    let limits = ReadLimits::default();
    let file = FileBytes::open(path, &limits)?;
    caught(path, || read_bytes(path, Bytes::from_owner(file), &limits))
}

fn read_bytes(path: &Path, bytes: Bytes, limits: &ReadLimits) -> Result<Table, DatasetError> {
    let unusable =
        |error: ParquetError| DatasetError::Parquet { path: path.into(), what: error.to_string() };
    let refused = |what: String| DatasetError::Parquet { path: path.into(), what };
    let reader = SerializedFileReader::new(bytes.clone()).map_err(unusable)?;
    let metadata = reader.metadata();
    let leaves = metadata.file_metadata().schema_descr().columns();
    let names: Vec<_> = leaves.iter().map(|leaf| leaf.path().string()).collect();
    limits.check(path, Limit::Columns, || "columns of the table".into(), names.len() as u64)?;
    let places = column_places(path, names.iter().map(String::as_str))?;
    for &(column, place) in &places {
        check_type(column, &leaves[place]).map_err(refused)?;
    }
    let n_rows = check_groups(metadata, &bytes, &places).map_err(refused)?;
    limits.check(path, Limit::Samples, || "rows of the table".into(), n_rows as u64)?;
    let mut rows = vec![StepRow::default(); n_rows];
    let mut names = NameCache::default();
    let mut begin = 0;
    for number in 0..metadata.num_row_groups() {
        let group = reader.get_row_group(number).map_err(unusable)?;
        let end = begin + group.metadata().num_rows() as usize;
        for &(column, place) in &places {
            let part = &mut rows[begin..end];
            read_column(&*group, place, column, part, &mut names).map_err(|fault| match fault {
                Fault::Library(error) => unusable(error),
                Fault::Value(row, what) => {
                    refused(format!("row {}: {} is {what}", begin + row + 1, column.name))
                }
            })?;
        }
        begin = end;
    }
    let mut provenance = Provenance::default();
    for pair in metadata.file_metadata().key_value_metadata().into_iter().flatten() {
        provenance.push(&pair.key, pair.value.as_deref().unwrap_or_default());
    }
    Ok(Table { rows, provenance })
}

fn check_type(column: &Column, leaf: &ColumnDescriptor) -> Result<(), String> {
    let found = (leaf.physical_type(), leaf.converted_type());
    let (is_right, expected) = match column.access {
        Access::Text(..) => (
            matches!(found, (PhysicalType::BYTE_ARRAY, ConvertedType::UTF8)),
            "text (BYTE_ARRAY, UTF8)",
        ),
        Access::Integer(..) => {
            (found == (PhysicalType::INT32, ConvertedType::UINT_32), "INT32, UINT_32")
        }
        Access::Real(..) | Access::OptionalReal(..) => (found.0 == PhysicalType::DOUBLE, "DOUBLE"),
    };
    if is_right && leaf.max_rep_level() == 0 && leaf.max_def_level() <= 1 {
        return Ok(());
    }
    let (physical, converted) = found;
    Err(format!(
        "column {} is of type {physical}, {converted} (levels {}, {}), expected {expected}",
        column.name,
        leaf.max_def_level(),
        leaf.max_rep_level()
    ))
}

/// The number of rows, if the row groups and their pages are what the metadata say.
fn check_groups(
    metadata: &ParquetMetaData,
    bytes: &[u8],
    places: &[(&'static Column, usize)],
) -> Result<usize, String> {
    let mut n_rows = 0_usize;
    for group in metadata.row_groups() {
        let rows = usize::try_from(group.num_rows()).unwrap_or(usize::MAX);
        n_rows = n_rows.saturating_add(rows);
        // A row has a time of its own, which takes more than a byte however it is compressed.
        if n_rows > bytes.len() {
            return Err(format!("{n_rows} rows in a file of {} bytes", bytes.len()));
        }
        for &(_, place) in places {
            let name = metadata.file_metadata().schema_descr().column(place).name().to_owned();
            check_chunk(group, place, bytes).map_err(|what| format!("column {name}: {what}"))?;
        }
    }
    Ok(n_rows)
}

fn check_chunk(group: &RowGroupMetaData, place: usize, bytes: &[u8]) -> Result<(), String> {
    let chunk = group.columns().get(place).ok_or("it is not in every row group")?;
    let is_compressed = match chunk.compression() {
        Compression::UNCOMPRESSED => false,
        Compression::SNAPPY => true,
        other => return Err(format!("compression {other} is not read; write it with snappy")),
    };
    let range = byte_range(chunk).filter(|range| range.end <= bytes.len());
    let range = range.ok_or_else(|| {
        let (start, length) = (chunk.data_page_offset(), chunk.compressed_size());
        format!("{length} bytes from byte {start} on in a file of {} bytes", bytes.len())
    })?;
    let n_rows = group.num_rows() as usize;
    check_pages(&Chunk { bytes: &bytes[range.clone()], start: range.start, n_rows, is_compressed })
}

fn byte_range(chunk: &ColumnChunkMetaData) -> Option<std::ops::Range<usize>> {
    let start = chunk.dictionary_page_offset().unwrap_or(chunk.data_page_offset());
    let start = usize::try_from(start).ok()?;
    Some(start..start.checked_add(usize::try_from(chunk.compressed_size()).ok()?)?)
}

/// Why a column cannot be read.
enum Fault {
    Library(ParquetError),
    /// Row in the group, value and what is expected.
    Value(usize, String),
}

impl From<ParquetError> for Fault {
    fn from(error: ParquetError) -> Self {
        Self::Library(error)
    }
}

fn read_column(
    group: &dyn RowGroupReader,
    place: usize,
    column: &Column,
    rows: &mut [StepRow],
    names: &mut NameCache,
) -> Result<(), Fault> {
    let max_level = group.metadata().column(place).column_descr().max_def_level();
    let reader = group.get_column_reader(place)?;
    let is_empty = |value: bool| {
        let wanted = || Err(("nothing".to_owned(), "a value".to_owned()));
        if value { Ok(()) } else { wanted() }
    };
    match &column.access {
        Access::Text(_, set) => {
            let cells = cells::<ByteArrayType>(reader, max_level, rows.len())?;
            fill(rows, cells, |row, cell: Option<ByteArray>| {
                let Some(cell) = cell else { return Ok(()) };
                let text = str::from_utf8(cell.data())
                    .map_err(|_| ("no UTF-8".to_owned(), "text".to_owned()))?;
                set(row, text).map_err(|expected| (text.to_owned(), expected))?;
                names.share(row);
                Ok(())
            })
        }
        Access::Integer(..) => {
            let cells = cells::<Int32Type>(reader, max_level, rows.len())?;
            fill(rows, cells, |row, cell: Option<i32>| {
                is_empty(cell.is_some())?;
                let value = f64::from(cell.unwrap_or_default().cast_unsigned());
                column.set_number(row, value).map_err(|expected| (value.to_string(), expected))
            })
        }
        Access::Real(..) | Access::OptionalReal(..) => {
            let is_optional = matches!(column.access, Access::OptionalReal(..));
            let cells = cells::<DoubleType>(reader, max_level, rows.len())?;
            fill(rows, cells, |row, cell: Option<f64>| {
                let Some(value) = cell else { return is_empty(is_optional) };
                column.set_number(row, value).map_err(|expected| (value.to_string(), expected))
            })
        }
    }
}

/// The values of a column in one row group, none where it has none.
fn cells<T: DataType>(
    reader: ColumnReader,
    max_level: i16,
    n_rows: usize,
) -> Result<Vec<Option<T::T>>, Fault> {
    let mut reader = get_typed_column_reader::<T>(reader);
    let (mut values, mut levels) = (Vec::new(), Vec::new());
    let (n_read, ..) = reader.read_records(n_rows, Some(&mut levels), None, &mut values)?;
    let is_whole = n_read == n_rows && (max_level == 0 || levels.len() == n_rows);
    let mut values = values.into_iter();
    let cells: Vec<_> = (0..n_rows)
        .map(|row| if max_level == 0 || levels.get(row) == Some(&1) { values.next() } else { None })
        .collect();
    if !is_whole || values.next().is_some() {
        let what = format!("{n_read} values where there are {n_rows} rows");
        return Err(Fault::Library(ParquetError::General(what)));
    }
    Ok(cells)
}

fn fill<T>(
    rows: &mut [StepRow],
    cells: Vec<Option<T>>,
    mut set: impl FnMut(&mut StepRow, Option<T>) -> Result<(), (String, String)>,
) -> Result<(), Fault> {
    for (number, (row, cell)) in rows.iter_mut().zip(cells).enumerate() {
        set(row, cell).map_err(|(value, expected)| {
            Fault::Value(number, format!("{value}, expected {expected}"))
        })?;
    }
    Ok(())
}
