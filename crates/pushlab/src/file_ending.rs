//! Kinds of files by how their names end, for the parser of the command line.

use std::path::PathBuf;

/// A step table.
pub(crate) fn table(text: &str) -> Result<PathBuf, String> {
    ending(text, &["csv", "parquet"])
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
    use super::table;

    #[test]
    fn other_endings_are_refused_with_the_allowed_ones() {
        assert_eq!(table("a/b.parquet").unwrap().to_str(), Some("a/b.parquet"));
        for text in ["a.xlsx", "csv", ".csv", "a.CSV"] {
            let error = table(text).unwrap_err();
            assert_eq!(error, "expected a file that ends in .csv or .parquet", "{text}");
        }
    }
}
