//! Every Rust file begins with what it is.

use super::Rule;
use super::project::{Finding, Project};

pub(super) const RULE: Rule = Rule {
    name: "file-head",
    demand: "a Rust file begins with a `//!` line, a library root with its README",
    check,
};

fn check(project: &Project) -> Vec<Finding> {
    let has_head = |path: &str, text: &str| {
        let head = text.lines().next().unwrap_or_default();
        let is_sentence = head.strip_prefix("//! ").is_some_and(|words| !words.trim().is_empty());
        is_sentence || (path.ends_with("/lib.rs") && head.starts_with("#![doc = include_str!("))
    };
    let headless = project.rust_files().iter().filter(|file| !has_head(&file.path, &file.text));
    let remedy = "begin with one `//!` line that says what the file is";
    headless.map(|file| Finding::new(&file.path, 1, "no file documentation", remedy)).collect()
}

#[cfg(test)]
mod tests {
    use super::super::project::Project;
    use super::check;

    #[test]
    fn a_first_line_of_documentation_is_demanded() {
        for (path, text, n_findings) in [
            ("crates/a/src/pose.rs", "//! Poses.\n", 0),
            ("crates/a/src/lib.rs", "#![doc = include_str!(\"../README.md\")]\n", 0),
            ("crates/a/src/pose.rs", "use std::fmt;\n", 1),
            ("crates/a/src/pose.rs", "//!\n//! Poses.\n", 1),
            ("crates/a/src/pose.rs", "", 1),
            ("crates/a/src/pose.rs", "#![doc = include_str!(\"../README.md\")]\n", 1),
        ] {
            assert_eq!(check(&Project::in_memory(&[(path, text)])).len(), n_findings, "{text:?}");
        }
    }
}
