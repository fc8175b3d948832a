//! Kinds of files by how their names end, for the parser of the command line.

use std::path::{Path, PathBuf};

/// The name of standard output, where an output of one file can go, too.
const STANDARD: &str = "-";

/// Whether an output is to be printed.
pub(crate) fn is_standard(path: &Path) -> bool {
    path == Path::new(STANDARD)
}

/// An output that is a folder.
pub(crate) fn folder(text: &str) -> Result<PathBuf, String> {
    match text {
        STANDARD => Err("a folder cannot go to standard output; name one".to_owned()),
        _ => Ok(text.into()),
    }
}

/// An output of one file, of a kind that [`table`] and the others know, or standard output.
pub(crate) fn or_standard(
    kind: fn(&str) -> Result<PathBuf, String>,
) -> impl Fn(&str) -> Result<PathBuf, String> + Clone {
    move |text| if text == STANDARD { Ok(text.into()) } else { kind(text) }
}

/// A step table.
pub(crate) fn table(text: &str) -> Result<PathBuf, String> {
    ending(text, &["csv", "parquet"])
}

/// A list.
pub(crate) fn csv(text: &str) -> Result<PathBuf, String> {
    ending(text, &["csv"])
}

/// A report.
pub(crate) fn report(text: &str) -> Result<PathBuf, String> {
    ending(text, &["txt", "json"])
}

/// A model.
pub(crate) fn model(text: &str) -> Result<PathBuf, String> {
    ending(text, &["toml"])
}

/// An answer for programs.
pub(crate) fn json(text: &str) -> Result<PathBuf, String> {
    ending(text, &["json"])
}

/// An answer for programs, or a table.
pub(crate) fn json_or_table(text: &str) -> Result<PathBuf, String> {
    ending(text, &["json", "csv", "parquet"])
}

/// A page.
pub(crate) fn page(text: &str) -> Result<PathBuf, String> {
    ending(text, &["html"])
}

fn ending(text: &str, allowed: &[&str]) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    match path.extension().and_then(|ending| ending.to_str()) {
        Some(ending) if allowed.contains(&ending) => Ok(path),
        _ => Err(format!("expected a file that ends in .{}", allowed.join(" or ."))),
    }
}

#[cfg(test)]
mod tests {
    use super::{folder, is_standard, or_standard, table};

    #[test]
    fn other_endings_are_refused_with_the_allowed_ones() {
        assert_eq!(table("a/b.parquet").unwrap().to_str(), Some("a/b.parquet"));
        for text in ["a.xlsx", "csv", ".csv", "a.CSV"] {
            let error = table(text).unwrap_err();
            assert_eq!(error, "expected a file that ends in .csv or .parquet", "{text}");
        }
    }

    #[test]
    fn standard_output_takes_the_place_of_one_file() {
        assert!(is_standard(&or_standard(table)("-").unwrap()));
        assert!(!is_standard(&or_standard(table)("./-.csv").unwrap()));
        assert!(or_standard(table)("a.txt").is_err() && table("-").is_err());
        assert!(folder("-").unwrap_err().contains("standard output") && folder("out").is_ok());
    }
}
