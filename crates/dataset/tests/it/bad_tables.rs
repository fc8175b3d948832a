//! Tables with numbers that no push has, in every form of file: refused with column and range.

use std::path::{Path, PathBuf};

use dataset::{StepRow, Table, columns};

fn endings() -> impl Iterator<Item = &'static str> {
    ["csv"].into_iter().chain(cfg!(feature = "parquet").then_some("parquet"))
}

fn row(recording: &str) -> StepRow {
    StepRow { recording: recording.into(), shape: "square".into(), dt: 0.2, ..StepRow::default() }
}

/// The messages on a table whose second row is spoilt, as CSV and as Parquet.
fn errors(spoil: impl Fn(&mut StepRow)) -> Vec<String> {
    let mut table = Table { rows: vec![row("a"), row("b"), row("c")], ..Table::default() };
    spoil(&mut table.rows[1]);
    let dir = tempfile::tempdir().unwrap();
    let refused = |ending| {
        let path = dir.path().join("table").with_extension(ending);
        table.write(&path).unwrap();
        let error = Table::read(&path).expect_err("a table that should be refused").to_string();
        error.replace(dir.path().to_str().unwrap(), "SET")
    };
    endings().map(refused).collect()
}

#[test]
fn numbers_that_no_push_has_are_refused_with_column_value_unit_and_range() {
    type Spoil = fn(&mut StepRow);
    let cases: [(Spoil, &str); 11] = [
        (|row| row.dt = -0.2, "dt_s is -0.2, expected 1e-9 to 1e6 s"),
        (|row| row.dt = 0.0, "dt_s is 0, expected 1e-9 to 1e6 s"),
        (|row| row.p = 2.5, "p is 2.5, expected 0 to 1"),
        (|row| row.p = -0.1, "p is -0.1, expected 0 to 1"),
        (|row| row.edge = u32::MAX, "edge is 4294967295, expected a whole number, 0 to 9999"),
        (|row| row.dx = f64::INFINITY, "dx_m is inf, expected -1e12 to 1e12 m"),
        (|row| row.dtheta = f64::NAN, "dtheta_rad is NaN, expected -1e12 to 1e12 rad"),
        (|row| row.speed = -1.0, "speed_m_s is -1, expected 0 to 1e12 m/s"),
        (|row| row.end_angle_sd = -1e9, "end_angle_sd_rad is -1000000000, expected 0 to 1e12 rad"),
        (|row| row.contact_normal.x = 1.5, "normal_x is 1.5, expected -1.000001 to 1.000001"),
        (|row| row.slip = 1e300, "expected -1e12 to 1e12 m"),
    ];
    for (spoil, says) in cases {
        for (message, place) in errors(spoil).into_iter().zip(["csv:3: ", "parquet: row 2: "]) {
            // In text the value stands as it was written.
            let plain = message.replace('`', "");
            assert!(plain.starts_with(&format!("SET/table.{place}")), "{message}");
            assert!(plain.contains(says), "{says}: {message}");
        }
    }
}

#[test]
fn every_column_of_numbers_refuses_what_is_out_of_its_range() {
    for column in columns().iter().filter(|column| !column.unit.is_empty()) {
        let (low, high) = column.range();
        assert!(low < high && low.is_finite() && high.is_finite(), "{}", column.name);
    }
    assert!(columns().iter().any(|column| column.name == "dt_s" && column.range().0 > 0.0));
}

fn written(dir: &Path) -> PathBuf {
    let path = dir.join("table.csv");
    Table { rows: vec![row("a"), row("b")], ..Table::default() }.write(&path).unwrap();
    path
}

#[test]
fn a_column_that_is_there_twice_is_refused_with_both_places() {
    let dir = tempfile::tempdir().unwrap();
    let path = written(dir.path());
    let text = std::fs::read_to_string(&path).unwrap();
    let doubled: String = text
        .lines()
        .enumerate()
        .map(|(line, text)| format!("{text},{}\n", if line == 0 { "p" } else { "0.5" }))
        .collect();
    std::fs::write(&path, doubled).unwrap();
    let message = Table::read(&path).unwrap_err().to_string();
    let says = "column `p` is there more than once, as number 11 and 51; keep one of them";
    assert!(message.ends_with(says), "{message}");
}

#[cfg(feature = "parquet")]
mod parquet {
    use super::{Table, row};

    /// Every byte of a small file, damaged in some ways: an error or a table, in time and memory.
    #[test]
    fn a_damaged_file_is_refused_or_read_and_never_ends_the_program() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("table.parquet");
        let table = Table { rows: vec![row("a"), row("b")], ..Table::default() };
        table.write(&path).unwrap();
        let whole = std::fs::read(&path).unwrap();
        let mut n_refused = 0;
        for at in (0..whole.len()).step_by(7) {
            for value in [0x00, 0x7f, 0xff] {
                let mut bytes = whole.clone();
                bytes[at] = value;
                std::fs::write(&path, &bytes).unwrap();
                n_refused += usize::from(Table::read(&path).is_err());
            }
        }
        assert!(n_refused > 100, "{n_refused}");
    }
}
