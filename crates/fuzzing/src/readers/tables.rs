//! Step tables: our own as CSV and Parquet, and those of others through a mapping.

use std::fs;
use std::path::Path;

use anyhow::Result;
use dataset::{
    ContactForce, Flags, Phase, Provenance, StepForce, StepRow, Table, TableMapping, columns,
};

use super::super::reader::{Reader, Verdict};

/// Our table as CSV.
pub(super) struct CsvTable;
/// Our table as Parquet.
pub(super) struct ParquetTable;
/// The table of the MIT square as CSV.
pub(super) struct MappedTable;

/// Rows of two recordings, with and without what may be missing.
fn table(n_rows: u32) -> Table {
    let row = |k: u32| {
        let force = ContactForce { normal: 1.0 + f64::from(k), tangential: -0.5 };
        StepRow {
            recording: if k.is_multiple_of(2) { "push-0".into() } else { "push-1".into() },
            session: (k.is_multiple_of(2)).then(|| "monday".into()),
            shape: "square".into(),
            step: k,
            phase: if k == 0 { Phase::Contact } else { Phase::After },
            t: 1.7e9 + 0.2 * f64::from(k),
            dt: 0.2,
            n_samples: 20,
            edge: 1,
            p: 0.25 * f64::from(k % 4),
            beta: 0.1,
            speed: 0.02,
            dx: 0.004 - 1e-5 * f64::from(k),
            force: (k.is_multiple_of(2)).then_some(StepForce {
                mean: force,
                start: force,
                end: force,
            }),
            flags: if k == 1 { Flags::VERTEX } else { Flags::default() },
            ..StepRow::default()
        }
    };
    let mut provenance = Provenance::default();
    provenance.push("tool", "pushlab");
    Table { rows: (0..n_rows).map(row).collect(), provenance }
}

/// What is wrong with a table that was read.
pub(super) fn wrong(table: &Table) -> Option<String> {
    table.rows.iter().enumerate().find_map(|(number, row)| {
        let number_of = |name: &str| format!("{name} is not allowed in row {number}");
        for column in columns() {
            if column.number(row).is_some_and(|value| !value.is_finite()) {
                return Some(number_of(column.name));
            }
        }
        if row.dt.is_nan() || row.dt <= 0.0 {
            return Some(number_of("dt_s"));
        }
        (!(0.0..=1.0).contains(&row.p)).then(|| number_of("p"))
    })
}

fn written(name: &str, n_rows: u32, dir: &Path) -> Result<Vec<u8>> {
    let path = dir.join(name);
    table(n_rows).write(&path)?;
    Ok(fs::read(path)?)
}

fn read_file(dir: &Path, name: &str, input: &[u8]) -> Verdict {
    let path = dir.join(name);
    match fs::write(&path, input) {
        Ok(()) => Verdict::of(Table::read(&path), wrong),
        Err(error) => Verdict::Wrong(format!("scratch is not usable: {error}")),
    }
}

impl Reader for CsvTable {
    fn name(&self) -> &'static str {
        "table-csv"
    }

    fn corpus(&self, dir: &Path) -> Result<Vec<Vec<u8>>> {
        Ok(vec![written("a.csv", 3, dir)?, written("b.csv", 2, dir)?])
    }

    fn tokens(&self) -> &'static [&'static str] {
        &["dt_s", "p", "edge", "contact", "after", "vertex|untared", "\"", ",,", "# a: b\n", "\r"]
    }

    fn read(&self, dir: &Path, input: &[u8]) -> Verdict {
        read_file(dir, "table.csv", input)
    }
}

impl Reader for ParquetTable {
    fn name(&self) -> &'static str {
        "table-parquet"
    }

    fn corpus(&self, dir: &Path) -> Result<Vec<Vec<u8>>> {
        Ok(vec![written("a.parquet", 2, dir)?, written("b.parquet", 40, dir)?])
    }

    fn tokens(&self) -> &'static [&'static str] {
        &["PAR1", "recording", "dt_s", "\x15\x00", "\x15\x04", "\x15\x06", "\x19\x1c", "\x26\x00"]
    }

    fn read(&self, dir: &Path, input: &[u8]) -> Verdict {
        read_file(dir, "table.parquet", input)
    }
}

impl Reader for MappedTable {
    fn name(&self) -> &'static str {
        "table-mapped"
    }

    fn corpus(&self, _: &Path) -> Result<Vec<Vec<u8>>> {
        let text = "c,phi_rad,dx_c_m,dy_c_m_sign_flipped,dtheta_rad\n0.2,0.0,0.003,0.0,-0.03\n\
                    0.5,0.5,0.003,0.001,0.0\n0.9,-0.5,0.002,0.001,0.01\n";
        Ok(vec![text.as_bytes().to_vec()])
    }

    fn read(&self, dir: &Path, input: &[u8]) -> Verdict {
        let path = dir.join("table.csv");
        if let Err(error) = fs::write(&path, input) {
            return Verdict::Wrong(format!("scratch is not usable: {error}"));
        }
        Verdict::of(TableMapping::mit_table().and_then(|mapping| mapping.read_table(&path)), wrong)
    }
}
