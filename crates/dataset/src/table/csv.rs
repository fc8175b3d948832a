//! The step table as CSV: comment lines `# key: value` with its provenance, a header, the rows.

use std::{
    collections::HashSet,
    io::{self, BufRead, Seek, Write},
    path::{Path, PathBuf},
    sync::Arc,
};

use output::OutputFile;
use tempfile::NamedTempFile;

use crate::error::DatasetError;
use crate::input::limits::{Limit, ReadLimits};
use crate::input::map::FileBytes;
use crate::table::column::{Access, Column, column_places, written_columns};
use crate::table::step::StepRow;
use crate::table::{Provenance, Table};

/// Writes rows as they come into a file of their own: the provenance, which stands above them, is
/// known last.
pub(crate) struct RowsFile {
    /// Of the table, for messages.
    path: PathBuf,
    writer: csv::Writer<NamedTempFile>,
    /// Those of the first row, once it is there.
    columns: Vec<&'static Column>,
}

/// Bytes of rows between two writes.
const BUFFER: usize = 1 << 16;

impl RowsFile {
    pub(crate) fn begin(output: &OutputFile) -> Result<Self, DatasetError> {
        let mut builder = csv::WriterBuilder::new();
        let writer = builder.buffer_capacity(BUFFER).from_writer(output.begin()?);
        Ok(Self { path: output.path().into(), writer, columns: Vec::new() })
    }

    pub(crate) fn write(&mut self, row: &StepRow) -> Result<(), DatasetError> {
        if self.columns.is_empty() {
            self.head(row.is_whole_push())?;
        }
        let cells: Vec<_> = self.columns.iter().map(|column| cell(column, row)).collect();
        self.record(cells.into_iter())
    }

    fn head(&mut self, has_way: bool) -> Result<(), DatasetError> {
        self.columns = written_columns(has_way).collect();
        let names: Vec<_> = self.columns.iter().map(|column| column.name).collect();
        self.record(names.into_iter())
    }

    /// Writes the provenance and then everything from the file of the rows into `part`.
    pub(crate) fn finish(
        mut self,
        provenance: &Provenance,
        mut part: NamedTempFile,
    ) -> Result<NamedTempFile, DatasetError> {
        if self.columns.is_empty() {
            self.head(false)?;
        }
        let Self { path, writer, .. } = self;
        let copy = || -> io::Result<NamedTempFile> {
            let mut rows = writer.into_inner().map_err(csv::IntoInnerError::into_error)?;
            rows.rewind()?;
            let line = |(key, value): &(String, String)| format!("# {key}: {value}\n");
            let head: String = provenance.entries.iter().map(line).collect();
            part.write_all(head.as_bytes())?;
            io::copy(rows.as_file_mut(), part.as_file_mut())?;
            Ok(part)
        };
        copy().map_err(|error| DatasetError::io("write", &path, error))
    }

    fn record<T: AsRef<[u8]>>(
        &mut self,
        cells: impl Iterator<Item = T>,
    ) -> Result<(), DatasetError> {
        let written = self.writer.write_record(cells);
        written.map_err(|error| DatasetError::io("write", &self.path, error.into()))
    }
}

/// Reads a table from CSV.
pub(crate) fn read(path: &Path) -> Result<Table, DatasetError> {
    let limits = ReadLimits::default();
    let file = FileBytes::open(path, &limits)?;
    let mut bytes = file.bytes();
    let (provenance, head_lines) = read_provenance(path, &mut bytes)?;
    let mut reader = csv::Reader::from_reader(bytes);
    let parse = |line: u64, what: String| DatasetError::Parse {
        path: path.into(),
        line: line + head_lines,
        what,
    };
    let header = reader.headers().map_err(|error| parse(1, error.to_string()))?.clone();
    limits.check(path, Limit::Columns, || "columns of the table".into(), header.len() as u64)?;
    let places = column_places(path, header.iter())?;
    let mut names = NameCache::default();
    let mut rows = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|error| {
            parse(error.position().map_or(0, csv::Position::line), error.to_string())
        })?;
        let line = record.position().map_or(0, csv::Position::line);
        let n_rows = rows.len() as u64 + 1;
        limits.check(path, Limit::Samples, || "rows of the table".into(), n_rows)?;
        let mut row = StepRow::default();
        for &(column, place) in &places {
            let text = record.get(place).unwrap_or_default();
            column.set_text(&mut row, text).map_err(|expected| {
                parse(line, format!("{} is `{text}`, expected {expected}", column.name))
            })?;
        }
        names.share(&mut row);
        rows.push(row);
    }
    Ok(Table { rows, provenance })
}

/// The comment lines before the header, and their number.
fn read_provenance(path: &Path, file: &mut &[u8]) -> Result<(Provenance, u64), DatasetError> {
    let fail = |error| DatasetError::io("read", path, error);
    let mut provenance = Provenance::default();
    let mut lines = 0;
    while file.first() == Some(&b'#') {
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

/// Rows with the same names share the memory of them.
#[derive(Default)]
pub(crate) struct NameCache(HashSet<Arc<str>>);

impl NameCache {
    pub(crate) fn share(&mut self, row: &mut StepRow) {
        for name in [&mut row.recording, &mut row.shape].into_iter().chain(&mut row.session) {
            match self.0.get(name) {
                Some(known) => *name = known.clone(),
                None => drop(self.0.insert(name.clone())),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use nalgebra::Vector2;
    use proptest::prelude::{ProptestConfig, prop_assert_eq, proptest};

    use crate::error::DatasetError;
    use crate::table::flags::Flags;
    use crate::table::step::{ContactForce, Phase, StepForce, StepRow};
    use crate::table::{Provenance, Table};

    fn table(a: f64, b: f64, forced: bool, n: u32) -> Table {
        let mut provenance = Provenance::default();
        provenance.push("tool", "pushlab 1: test");
        provenance.push("source", "sha256 00 a.csv");
        provenance.push("source", "sha256 01 b.csv");
        let force = ContactForce { normal: a, tangential: b };
        let row = StepRow {
            recording: "a \"quoted\", name".into(),
            session: forced.then(|| "monday".into()),
            push: n,
            phase: if forced { Phase::After } else { Phase::Contact },
            t: 1.7e9 + a,
            dt: 0.2,
            dx: a,
            dtheta: b,
            pusher_end: Vector2::new(b, -a),
            force: forced.then_some(StepForce { mean: force, start: force, end: force }),
            flags: if forced { Flags::VERTEX | Flags::UNTARED } else { Flags::default() },
            ..StepRow::default()
        };
        let other = StepRow { recording: "b".into(), dy: a * b, ..StepRow::default() };
        Table { rows: vec![row, other], provenance }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]

        #[test]
        fn files_return_every_bit(
            a in -1e6..1e6_f64,
            b in proptest::num::f64::SUBNORMAL,
            forced: bool,
            n: u32,
        ) {
            let mut written = table(a, b, forced, n);
            written.rows[1].dy = 0.1 + f64::from(n);
            let dir = tempfile::tempdir().unwrap();
            let mut names = vec!["table.csv"];
            if cfg!(feature = "parquet") {
                names.push("table.parquet");
            }
            for name in names {
                let path = dir.path().join(name);
                written.write(&path).unwrap();
                prop_assert_eq!(&Table::read(&path).unwrap(), &written);
            }
        }
    }

    fn error(change: impl Fn(String) -> String) -> String {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("table.csv");
        table(0.5, 0.25, true, 3).write(&path).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, change(text)).unwrap();
        let message = Table::read(&path).unwrap_err().to_string();
        message.replace(dir.path().to_str().unwrap(), "SET")
    }

    #[test]
    fn provenance_stands_above_the_header() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("table.csv");
        table(0.5, 0.25, false, 3).write(&path).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.starts_with("# tool: pushlab 1: test\n# source: sha256 00 a.csv\n"), "{text}");
        assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_wrong_column_is_named_with_those_that_are_there() {
        let message = error(|text| text.replace("beta_rad", "beta_deg"));
        assert!(message.starts_with("SET/table.csv: no column `beta_rad`; the table has: rec"));
        assert!(message.contains("beta_deg"), "{message}");
    }

    #[test]
    fn a_wrong_value_is_named_with_its_line_and_unit() {
        let message = error(|text| text.replacen(",0.5,", ",NaN,", 1));
        assert_eq!(message, "SET/table.csv:5: dx_m is `NaN`, expected -1e12 to 1e12 m");
        let message = error(|text| text.replace("after", "later"));
        assert_eq!(message, "SET/table.csv:5: phase is `later`, expected contact or after");
        let message = error(|text| text.replace("vertex|", "vortex|"));
        assert!(message.contains("flags is `vortex|untared`, expected flags out of"), "{message}");
    }

    #[test]
    fn a_table_with_one_row_is_refused() {
        let message = error(|text| text.lines().take(5).map(|line| format!("{line}\n")).collect());
        assert_eq!(
            message,
            "SET/table.csv: the table has 1 row(s); at least 2 are needed, ingest more pushes"
        );
    }

    #[test]
    fn a_missing_file_and_a_wrong_extension_are_refused() {
        let missing = Table::read(Path::new("nowhere/table.csv"));
        assert!(matches!(missing, Err(DatasetError::Io { action: "read", .. })));
        let message = Table::read(Path::new("table.xlsx")).unwrap_err().to_string();
        assert!(message.contains("tables end in .csv or .parquet, not .xlsx"), "{message}");
    }
}
