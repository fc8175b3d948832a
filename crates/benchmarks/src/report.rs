//! A benchmark's rows as a table and as `target/bench/NAME.json`.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use serde::de::DeserializeOwned;

use super::timing::Row;

/// Prints the rows as a table and writes them as `NAME.json` in `folder`.
///
/// # Errors
/// When the file cannot be written.
pub(crate) fn publish(name: &str, rows: &[Row], folder: &Path) -> Result<()> {
    print!("{}", table(rows));
    let path = write(name, rows, folder)?;
    println!("written to {}", path.display());
    Ok(())
}

fn table(rows: &[Row]) -> String {
    let width = rows.iter().map(|row| row.name.chars().count()).max().unwrap_or(0).max(4);
    let mut text = format!(
        "{:width$} {:>9} {:>7} {:>12} {:>12} {:>7}\n",
        "name", "size", "threads", "median", "reference", "ratio"
    );
    let has_memory = rows.iter().any(|row| row.peak_memory_mb.is_some());
    if has_memory {
        text.insert_str(text.len() - 1, &format!(" {:>10}", "memory"));
    }
    for row in rows {
        let reference = duration(row.reference_seconds);
        let median = duration(row.median_seconds);
        let memory = row.peak_memory_mb.map_or(String::new(), |mb| format!(" {mb:>7.0} MB"));
        writeln!(
            text,
            "{:width$} {:>9} {:>7} {median:>12} {reference:>12} {:>7}{memory}",
            row.name,
            row.size,
            row.threads,
            ratio(row.ratio)
        )
        .expect("a String takes any text");
    }
    text
}

/// Two digits after the point, or of a small one.
pub(crate) fn ratio(ratio: f64) -> String {
    if ratio < 0.1 { format!("{ratio:.1e}") } else { format!("{ratio:.2}") }
}

/// The time in the unit that leaves one to three digits before the point.
pub(crate) fn duration(seconds: f64) -> String {
    let units = [("s", 1.0), ("ms", 1e-3), ("µs", 1e-6)];
    let (unit, scale) =
        units.into_iter().find(|(_, scale)| seconds >= *scale).unwrap_or(("ns", 1e-9));
    format!("{:.2} {unit}", seconds / scale)
}

fn write(name: &str, rows: &[Row], folder: &Path) -> Result<PathBuf> {
    let path = folder.join(format!("{name}.json"));
    let json = serde_json::to_string_pretty(rows).context("cannot write the rows as JSON")? + "\n";
    fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))?;
    output::write(&path, json)?;
    Ok(path)
}

/// What a run left, if it was made.
pub(crate) fn read<T: DeserializeOwned>(folder: &Path, name: &str) -> Result<Option<Vec<T>>> {
    let path = folder.join(format!("{name}.json"));
    if !path.exists() {
        return Ok(None);
    }
    let text =
        fs::read_to_string(&path).with_context(|| format!("cannot read {}", path.display()))?;
    let rows = serde_json::from_str(&text);
    Ok(Some(rows.with_context(|| format!("{} is of another release", path.display()))?))
}

#[cfg(test)]
mod tests {
    use std::fs;

    use serde_json::{Value, json};

    use super::{Row, duration, publish, ratio, read, table};

    fn rows() -> [Row; 2] {
        [("ellip1", 3e-7, 0.5), ("hex", 1e-7, 1.5)].map(|(name, reference_seconds, ratio)| Row {
            name: name.into(),
            size: 1,
            threads: 2,
            median_seconds: 1.5e-7,
            reference_seconds,
            ratio,
            peak_memory_mb: None,
        })
    }

    #[test]
    fn the_table_is_aligned() {
        assert_eq!(
            table(&rows()),
            "name        size threads       median    reference   ratio\n\
             ellip1         1       2    150.00 ns    300.00 ns    0.50\n\
             hex            1       2    150.00 ns    100.00 ns    1.50\n"
        );
    }

    #[test]
    fn memory_has_a_column_where_it_was_measured() {
        let [mut first, second] = rows();
        first.peak_memory_mb = Some(123.4);
        assert_eq!(
            table(&[first, second]),
            "name        size threads       median    reference   ratio     memory\n\
             ellip1         1       2    150.00 ns    300.00 ns    0.50     123 MB\n\
             hex            1       2    150.00 ns    100.00 ns    1.50\n"
        );
    }

    #[test]
    fn a_small_ratio_keeps_its_digits() {
        assert_eq!([1.5, 0.104, 0.001_24].map(ratio), ["1.50", "0.10", "1.2e-3"]);
    }

    #[test]
    fn durations_choose_their_unit() {
        let texts = [2.0, 0.0125, 3.4e-6, 5e-9].map(duration);
        assert_eq!(texts, ["2.00 s", "12.50 ms", "3.40 µs", "5.00 ns"]);
    }

    #[test]
    fn publishing_replaces_the_file_and_leaves_nothing_else() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let target = folder.path().join("bench");
        publish("push", &[], &target).expect("an empty table");
        publish("push", &rows(), &target).expect("two rows");
        let text = fs::read_to_string(target.join("push.json")).expect("the file");
        let json: Value = serde_json::from_str(&text).expect("JSON");
        assert_eq!(
            json[0],
            json!({"name": "ellip1", "size": 1, "threads": 2, "median_seconds": 1.5e-7,
                   "reference_seconds": 3e-7, "ratio": 0.5})
        );
        assert_eq!(json[1]["ratio"], 1.5);
        assert_eq!(fs::read_dir(&target).expect("the folder").count(), 1);
    }

    #[test]
    fn a_folder_that_cannot_be_made_is_an_error_with_its_path() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let file = folder.path().join("file");
        fs::write(&file, "").expect("a file");
        let error = publish("push", &[], &file).expect_err("a file is no folder");
        assert!(error.to_string().ends_with("/file"), "{error}");
    }

    #[test]
    fn what_was_not_run_is_left_out_and_what_is_damaged_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        assert!(read::<Row>(folder.path(), "push").unwrap().is_none());
        std::fs::write(folder.path().join("push.json"), "[{}]").unwrap();
        let error = read::<Row>(folder.path(), "push").unwrap_err();
        assert!(error.to_string().contains("of another release"), "{error}");
    }
}
