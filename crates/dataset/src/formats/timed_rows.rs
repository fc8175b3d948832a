//! Samples of many pushes in one CSV file: `push`, `t_s` and two numbers.

use std::path::Path;

use nalgebra::Vector2;

use crate::error::DatasetError;
use crate::input::limits::{Limit, ReadLimits};

/// One sample.
pub(super) struct TimedRow {
    pub(super) push: u32,
    /// In s.
    pub(super) t: f64,
    pub(super) value: Vector2<f64>,
    /// Where it stands.
    pub(super) line: u64,
}

/// What is wrong with the form of a CSV file, with its line.
pub(super) fn csv_error(path: &Path, error: &csv::Error) -> DatasetError {
    let line = error.position().map_or(1, csv::Position::line);
    DatasetError::Parse { path: path.into(), line, what: error.to_string() }
}

/// The error for a column that is not there.
pub(super) fn column_missing(
    path: &Path,
    column: &str,
    header: &csv::StringRecord,
) -> DatasetError {
    DatasetError::ColumnMissing {
        path: path.into(),
        column: column.to_owned(),
        found: header.iter().collect::<Vec<_>>().join(", "),
    }
}

/// The rows of a file.
///
/// # Errors
/// As [`super::end_points::read_end_points`].
pub(super) fn timed_rows(
    path: &Path,
    bytes: &[u8],
    values: [&str; 2],
    limits: &ReadLimits,
) -> Result<Vec<TimedRow>, DatasetError> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut builder = csv::ReaderBuilder::new();
    let mut reader = builder.trim(csv::Trim::All).comment(Some(b'#')).from_reader(bytes);
    let header = reader.headers().map_err(|error| csv_error(path, &error))?.clone();
    limits.check(path, Limit::Columns, || "columns".into(), header.len() as u64)?;
    let [x, y] = values;
    let names = ["push", "t_s", x, y];
    let mut places = [0; 4];
    for (place, name) in places.iter_mut().zip(names) {
        let found = header.iter().position(|found| found == name);
        *place = found.ok_or_else(|| column_missing(path, name, &header))?;
    }
    let mut rows = Vec::new();
    let mut record = csv::StringRecord::new();
    while reader.read_record(&mut record).map_err(|error| csv_error(path, &error))? {
        limits.check(path, Limit::Samples, || "rows".into(), rows.len() as u64 + 1)?;
        let line = record.position().map_or(0, csv::Position::line);
        let fail = |column: usize, expected: &str| {
            let text = record.get(places[column]).unwrap_or_default();
            let what = format!("{} is `{text}`, expected {expected}", names[column]);
            DatasetError::Parse { path: path.into(), line, what }
        };
        let text = |column: usize| record.get(places[column]).unwrap_or_default();
        let number = |column: usize| {
            let number = text(column).parse::<f64>().ok().filter(|number| number.abs() <= 1e12);
            number.ok_or_else(|| fail(column, "a finite number, in SI units"))
        };
        let push = text(0).parse().ok();
        rows.push(TimedRow {
            push: push.ok_or_else(|| fail(0, "a whole number from 0 to 4294967295"))?,
            t: number(1)?,
            value: Vector2::new(number(2)?, number(3)?),
            line,
        });
    }
    Ok(rows)
}
