//! The step table as CSV: comment lines `# key: value` with its provenance, a header, the rows.

use std::{
    fs::File,
    io::{BufRead, BufReader, BufWriter, Write},
    path::{Path, PathBuf},
    sync::Arc,
};

use crate::{
    column::{Access, Column, columns},
    error::DatasetError,
    step::StepRow,
    table::{Provenance, Table},
};

/// Writes rows one at a time, so that a table never has to be in memory.
pub struct CsvWriter {
    path: PathBuf,
    writer: csv::Writer<BufWriter<File>>,
}

impl CsvWriter {
    /// Creates the file with its provenance and header.
    ///
    /// # Errors
    /// `Io` if the file cannot be written.
    pub fn create(path: &Path, provenance: &Provenance) -> Result<Self, DatasetError> {
        let fail = |error| DatasetError::io("write", path, error);
        let mut file = BufWriter::new(File::create(path).map_err(fail)?);
        for (key, value) in &provenance.entries {
            writeln!(file, "# {key}: {value}").map_err(fail)?;
        }
        let mut writer = csv::Writer::from_writer(file);
        let header = columns().iter().map(|column| column.name);
        writer.write_record(header).map_err(|error| fail(error.into()))?;
        Ok(Self { path: path.into(), writer })
    }

    /// Appends one row.
    ///
    /// # Errors
    /// `Io` if the file cannot be written.
    pub fn write(&mut self, row: &StepRow) -> Result<(), DatasetError> {
        let cells = columns().iter().map(|column| cell(column, row));
        let path = &self.path;
        self.writer.write_record(cells).map_err(|e| DatasetError::io("write", path, e.into()))
    }

    /// Writes out what is still in memory.
    ///
    /// # Errors
    /// `Io` if the file cannot be written.
    pub fn finish(mut self) -> Result<(), DatasetError> {
        self.writer.flush().map_err(|error| DatasetError::io("write", &self.path, error))
    }
}

/// Reads a table from CSV.
pub(crate) fn read(path: &Path) -> Result<Table, DatasetError> {
    let file = File::open(path).map_err(|error| DatasetError::io("read", path, error))?;
    let mut file = BufReader::new(file);
    let (provenance, head_lines) = read_provenance(path, &mut file)?;
    let mut reader = csv::Reader::from_reader(file);
    let parse = |line: u64, what: String| DatasetError::Parse {
        path: path.into(),
        line: line + head_lines,
        what,
    };
    let header = reader.headers().map_err(|error| parse(1, error.to_string()))?.clone();
    let places = columns()
        .iter()
        .map(|column| {
            header.iter().position(|name| name == column.name).ok_or_else(|| {
                DatasetError::ColumnMissing {
                    path: path.into(),
                    column: column.name.into(),
                    found: header.iter().collect::<Vec<_>>().join(", "),
                }
            })
        })
        .collect::<Result<Vec<_>, _>>()?;
    let mut names = NameCache::default();
    let mut rows = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|error| {
            parse(error.position().map_or(0, csv::Position::line), error.to_string())
        })?;
        let line = record.position().map_or(0, csv::Position::line);
        let mut row = StepRow::default();
        for (column, &place) in columns().iter().zip(&places) {
            let text = record.get(place).unwrap_or_default();
            fill(column, &mut row, text).map_err(|expected| {
                parse(line, format!("{} is `{text}`, expected {expected}", column.name))
            })?;
        }
        names.share(&mut row);
        rows.push(row);
    }
    Ok(Table { rows, provenance })
}

/// The comment lines before the header, and their number.
fn read_provenance(
    path: &Path,
    file: &mut BufReader<File>,
) -> Result<(Provenance, u64), DatasetError> {
    let fail = |error| DatasetError::io("read", path, error);
    let mut provenance = Provenance::default();
    let mut lines = 0;
    while file.fill_buf().map_err(fail)?.first() == Some(&b'#') {
        let mut line = String::new();
        file.read_line(&mut line).map_err(fail)?;
        lines += 1;
        if let Some((key, value)) = line[1..].split_once(':') {
            provenance.push(key, value);
        }
    }
    Ok((provenance, lines))
}

/// Numbers are written with the fewest digits that read back to the same bits.
fn cell(column: &Column, row: &StepRow) -> String {
    match &column.access {
        Access::Text(get, _) => get(row).unwrap_or_default(),
        Access::Integer(get, _) => get(row).to_string(),
        Access::Real(get, _) => get(row).to_string(),
        Access::OptionalReal(get, _) => get(row).map(|value| value.to_string()).unwrap_or_default(),
    }
}

fn fill(column: &Column, row: &mut StepRow, text: &str) -> Result<(), String> {
    let number = || match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ if column.unit == "1" => Err("a finite number".to_owned()),
        _ => Err(format!("a finite number in {}", column.unit)),
    };
    match &column.access {
        Access::Text(_, set) => set(row, text)?,
        Access::Integer(_, set) => {
            set(row, text.parse().map_err(|_| "a whole number from 0".to_owned())?);
        }
        Access::Real(_, set) => set(row, number()?),
        Access::OptionalReal(_, set) => {
            if !text.is_empty() {
                set(row, number()?);
            }
        }
    }
    Ok(())
}

/// Rows of one recording share the memory of its names.
#[derive(Default)]
pub(crate) struct NameCache {
    recording: Option<Arc<str>>,
    session: Option<Arc<str>>,
    shape: Option<Arc<str>>,
}

impl NameCache {
    pub(crate) fn share(&mut self, row: &mut StepRow) {
        let same = |known: &mut Option<Arc<str>>, name: &mut Arc<str>| match known {
            Some(known) if known == name => *name = known.clone(),
            _ => *known = Some(name.clone()),
        };
        same(&mut self.recording, &mut row.recording);
        same(&mut self.shape, &mut row.shape);
        if let Some(session) = &mut row.session {
            same(&mut self.session, session);
        }
    }
}
