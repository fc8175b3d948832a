//! CSV folders: `robot.csv`, `object.csv` and, where forces were recorded, `wrench.csv`.

use std::{
    io,
    path::{Path, PathBuf},
};

use csv::{ErrorKind, Reader, ReaderBuilder, StringRecord};

use super::find::find_recordings;
use crate::formats::assemble::{Assembly, RawStream, nanoseconds, wrong_time_unit};
use crate::formats::decode::N_VALUES;
use crate::formats::format::{Inspection, LogFormat, StreamInfo};
use crate::formats::log::fixed_transform;
use crate::formats::stamps::Stamps;
use crate::input::caught::caught;
use crate::input::limits::{Limit, ReadLimits};
use crate::input::map::{FileBytes, sha256};
use crate::recording::Recording;
use crate::recording::frames::Frames;
use crate::recording::settings::{ColumnMap, Quantity, StreamSettings, Streams};
use crate::{
    error::DatasetError,
    remark::{Remark, StreamRole},
};

/// The CSV format.
pub(crate) struct CsvFormat;

impl LogFormat for CsvFormat {
    fn id(&self) -> &'static str {
        "csv"
    }

    fn find(&self, dir: &Path) -> Result<Vec<PathBuf>, DatasetError> {
        self.find_streams(dir, &Streams::default())
    }

    fn find_streams(&self, dir: &Path, streams: &Streams) -> Result<Vec<PathBuf>, DatasetError> {
        let is_recording = |path: &Path| {
            let mut files = StreamRole::ALL[..2].iter().map(|role| file_of(path, *role, streams));
            files.any(|file| file.is_file())
        };
        let [robot, object, wrench] = StreamRole::ALL.map(|role| file_name(role, streams));
        let expected = format!("folders with {robot}, {object} and {wrench}");
        find_recordings(dir, self.id(), &expected, &is_recording)
    }

    fn read(
        &self,
        path: &Path,
        streams: &Streams,
        limits: &ReadLimits,
    ) -> Result<Recording, DatasetError> {
        caught(path, || read_folder(path, streams, limits))
    }

    fn inspect(&self, path: &Path, limits: &ReadLimits) -> Result<Inspection, DatasetError> {
        caught(path, || inspect_folder(path, limits))
    }
}

fn read_folder(
    path: &Path,
    streams: &Streams,
    limits: &ReadLimits,
) -> Result<Recording, DatasetError> {
    let file_of = |role| file_of(path, role, streams);
    let open = |role| FileBytes::open(&file_of(role), limits);
    let has_wrench = streams.wrench.topic.is_some() || file_of(StreamRole::Wrench).exists();
    let files = [open(StreamRole::Robot)?, open(StreamRole::Object)?];
    let wrench_file = has_wrench.then(|| open(StreamRole::Wrench)).transpose()?;
    let bytes = || files.iter().chain(&wrench_file).map(FileBytes::bytes);
    let mut raw = Vec::new();
    for (role, bytes) in StreamRole::ALL.into_iter().zip(bytes()) {
        raw.push(read_rows(&file_of(role), bytes, role, streams.of(role), limits)?);
    }
    let lengths: Vec<[u8; 8]> = bytes().map(|b| (b.len() as u64).to_le_bytes()).collect();
    let parts = lengths.iter().map(|length| length.as_slice()).zip(bytes());
    let sha256 = sha256(parts.flat_map(|(length, bytes)| [length, bytes]));
    let mut assembly = Assembly { path, sha256, remarks: Vec::new() };
    let mut placed = Vec::new();
    for (raw, role) in raw.iter().zip(StreamRole::ALL) {
        let transform = streams.of(role).transform.as_ref();
        let frames = Frames::default();
        let pose = fixed_transform(path, role, transform, &frames, &mut assembly.remarks)?;
        placed.push((raw, pose));
    }
    let wrench = placed.get(2).map(|(raw, pose)| (*raw, *pose, &streams.wrench));
    assembly.finish(placed[0], placed[1], wrench)
}

fn inspect_folder(path: &Path, limits: &ReadLimits) -> Result<Inspection, DatasetError> {
    let is_csv = |file: &Path| super::find::is_file_ending(file, &["csv"]);
    let files = find_recordings(path, CsvFormat.id(), "files NAME.csv", &is_csv)?;
    let found: Vec<_> =
        files.iter().map(|file| inspect_file(file, limits)).collect::<Result<_, _>>()?;
    let pauses = found.iter().filter_map(|(_, stamps)| stamps.pauses());
    let remarks = Remark::of_pauses(pauses).into_iter().collect();
    let streams = found.into_iter().map(|(info, _)| info).collect();
    Ok(Inspection { streams, remarks, ..Inspection::default() })
}

/// The name of a stream's file, as the manifest tells it.
fn file_name(role: StreamRole, streams: &Streams) -> String {
    streams.of(role).topic.clone().unwrap_or_else(|| format!("{role}.csv"))
}

/// A stream's file in a recording; the manifest may leave out its ending.
fn file_of(recording: &Path, role: StreamRole, streams: &Streams) -> PathBuf {
    let file = recording.join(file_name(role, streams));
    let with_ending = file.with_added_extension("csv");
    if !file.is_file() && with_ending.is_file() { with_ending } else { file }
}

/// The header of a quantity where the manifest names none.
pub(crate) fn default_column(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::T => "t_s",
        Quantity::X => "x_m",
        Quantity::Y => "y_m",
        Quantity::Z => "z_m",
        Quantity::Theta => "theta_rad",
        Quantity::Fx => "fx_n",
        Quantity::Fy => "fy_n",
        Quantity::Fz => "fz_n",
        Quantity::Tx => "tx_nm",
        Quantity::Ty => "ty_nm",
        Quantity::Tz => "tz_nm",
        Quantity::Qx | Quantity::Qy | Quantity::Qz | Quantity::Qw => quantity.name(),
    }
}

/// Reads one file; every row has a place, its line.
fn read_rows(
    file: &Path,
    bytes: &[u8],
    role: StreamRole,
    settings: &StreamSettings,
    limits: &ReadLimits,
) -> Result<RawStream, DatasetError> {
    let mut reader = reader(bytes);
    let headers = headers(file, &mut reader, limits)?;
    let source = file.file_name().unwrap_or_default().to_string_lossy();
    let mut raw = RawStream::new(role, &source, "line", &settings.columns);
    let column_of = |quantity: Quantity| {
        let column = settings.columns.get(&quantity).map(|map| map.column.as_str());
        let name = column.unwrap_or_else(|| default_column(quantity));
        let found = headers.iter().position(|header| header == name);
        match found {
            None if column.is_some() || is_required(role, quantity, &headers) => {
                Err(DatasetError::Parse {
                    path: file.into(),
                    line: 1,
                    what: format!(
                        "no column `{name}` among {}; set streams.{role}.columns.{}",
                        headers.join(", "),
                        quantity.name()
                    ),
                })
            }
            found => Ok(found),
        }
    };
    let time = column_of(Quantity::T)?.unwrap_or_default();
    let time_map = settings.columns.get(&Quantity::T);
    let mut columns = Vec::new();
    for (slot, quantity) in Quantity::of(role).iter().enumerate() {
        if let Some(column) = column_of(*quantity)? {
            raw.has[slot] = true;
            columns.push((slot, column));
        }
    }
    let mut record = StringRecord::new();
    while reader.read_record(&mut record).map_err(|error| csv_error(file, &error))? {
        let line = record.position().map_or(0, csv::Position::line);
        limits.check(file, Limit::Samples, || "rows".into(), raw.rows.len() as u64 + 1)?;
        let parse = |column: usize| number(file, line, &headers[column], &record[column]);
        let seconds = parse(time)?;
        let stamp = stamp(&record[time], seconds, time_map);
        let seconds = time_map.map_or(seconds, |map| map.scale * seconds + map.offset);
        if let Some(what) = wrong_time_unit(seconds, role, "columns") {
            let what = format!("column {}: {what}", headers[time]);
            return Err(DatasetError::Parse { path: file.into(), line, what });
        }
        let mut values = [0.0; N_VALUES];
        for &(slot, column) in &columns {
            values[slot] = parse(column)?;
        }
        match stamp {
            Some(stamp) => raw.push(stamp, &values, line),
            // A row without a time counts among those that are not finite.
            None => raw.push(0, &[f64::NAN; N_VALUES], line),
        }
    }
    Ok(raw)
}

/// Whether a stream cannot do without a column.
fn is_required(role: StreamRole, quantity: Quantity, headers: &[String]) -> bool {
    let quaternion = headers.iter().any(|header| header == default_column(Quantity::Qw));
    match quantity {
        Quantity::T | Quantity::X | Quantity::Y | Quantity::Fx | Quantity::Fy => true,
        Quantity::Theta => role == StreamRole::Object && !quaternion,
        _ => false,
    }
}

fn reader(bytes: &[u8]) -> Reader<&[u8]> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).from_reader(bytes)
}

fn headers(
    file: &Path,
    reader: &mut Reader<&[u8]>,
    limits: &ReadLimits,
) -> Result<Vec<String>, DatasetError> {
    let headers = reader.headers().map_err(|error| csv_error(file, &error))?;
    limits.check(file, Limit::Columns, || "columns".into(), headers.len() as u64)?;
    if headers.is_empty() {
        let what = "the file is empty, expected a line of column names".into();
        return Err(DatasetError::Parse { path: file.into(), line: 1, what });
    }
    Ok(headers.iter().map(String::from).collect())
}

fn number(file: &Path, line: u64, column: &str, text: &str) -> Result<f64, DatasetError> {
    text.parse().map_err(|_| DatasetError::Parse {
        path: file.into(),
        line,
        what: format!("`{text}` in column {column} is no number; write decimals with a point"),
    })
}

/// A time in ns: decimal digits exactly, anything else by its nearest number.
fn stamp(text: &str, seconds: f64, map: Option<&ColumnMap>) -> Option<i64> {
    let plain = map.is_none_or(|map| map.scale == 1.0 && map.offset == 0.0);
    if plain && let Some(exact) = decimal_nanoseconds(text) {
        return Some(exact);
    }
    let seconds = map.map_or(seconds, |map| map.scale * seconds + map.offset);
    seconds.is_finite().then(|| nanoseconds(seconds))
}

/// `seconds.fraction` with at most nine decimals, in ns.
fn decimal_nanoseconds(text: &str) -> Option<i64> {
    let (whole, fraction) = text.split_once('.').unwrap_or((text, ""));
    let digits = |part: &str| part.bytes().all(|byte| byte.is_ascii_digit());
    if whole.is_empty() || !digits(whole) || !digits(fraction) || fraction.len() > 9 {
        return None;
    }
    let fraction: i64 = format!("{fraction:0<9}").parse().ok()?;
    whole.parse::<i64>().ok()?.checked_mul(1_000_000_000)?.checked_add(fraction)
}

fn csv_error(file: &Path, error: &csv::Error) -> DatasetError {
    let line = error.position().map_or(1, csv::Position::line);
    let what = match error.kind() {
        ErrorKind::UnequalLengths { expected_len, len, .. } => {
            format!("{len} fields where the first line has {expected_len}; complete the row")
        }
        ErrorKind::Utf8 { err, .. } => format!("no UTF-8 text: {err}"),
        ErrorKind::Io(error) if error.kind() == io::ErrorKind::InvalidData => error.to_string(),
        _ => error.to_string(),
    };
    DatasetError::Parse { path: file.into(), line, what }
}

fn inspect_file(file: &Path, limits: &ReadLimits) -> Result<(StreamInfo, Stamps), DatasetError> {
    let bytes = FileBytes::open(file, limits)?;
    let mut reader = reader(bytes.bytes());
    let columns = headers(file, &mut reader, limits)?;
    let mut record = StringRecord::new();
    let (mut count, mut stamps) = (0, Stamps::default());
    while reader.read_record(&mut record).map_err(|error| csv_error(file, &error))? {
        count += 1;
        if let Ok(time) = record[0].parse::<f64>() {
            stamps.add(nanoseconds(time));
        }
    }
    let is_timed = columns[0] == default_column(Quantity::T);
    let stamps = if is_timed { stamps } else { Stamps::default() };
    let has = |names: &[Quantity]| {
        names.iter().all(|name| columns.iter().any(|column| column == default_column(*name)))
    };
    let fits = |role: &StreamRole| match role {
        StreamRole::Robot => has(&[Quantity::X, Quantity::Y]),
        StreamRole::Object => has(&[Quantity::X, Quantity::Y, Quantity::Theta]),
        StreamRole::Wrench => has(&[Quantity::Fx, Quantity::Fy]),
    };
    let info = StreamInfo {
        name: file.file_name().unwrap_or_default().to_string_lossy().into_owned(),
        count,
        rate_hz: stamps.rate_hz(),
        fits: StreamRole::ALL.into_iter().filter(fits).collect(),
        columns,
        ..StreamInfo::default()
    };
    Ok((info, stamps))
}

#[cfg(test)]
mod tests;
