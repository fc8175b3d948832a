//! No ignored test or example: what the compiler's lints do not know.

use super::Rule;
use super::project::{Finding, Project, RustFile};

pub(super) const RULE: Rule =
    Rule { name: "unfinished", demand: "no ignored test or example", check };

fn check(project: &Project) -> Vec<Finding> {
    let code = project.rust_files().iter().flat_map(check_code);
    let documents = project.texts().filter(|(path, _)| {
        path.ends_with(".rs") || (path.starts_with("crates/") && path.ends_with(".md"))
    });
    code.chain(documents.flat_map(|(path, text)| check_examples(path, text))).collect()
}

fn check_code(file: &RustFile) -> Vec<Finding> {
    let is_part = |letter: char| letter.is_alphanumeric() || letter == '_';
    let is_ignored = |line: &str| {
        let attribute = line.trim_start().strip_prefix("#[").unwrap_or_default();
        attribute.split(|letter| !is_part(letter)).any(|word| word == "ignore")
    };
    let ignored = file.code.lines().enumerate().filter(|(_, line)| is_ignored(line));
    let remedy = "make the test pass or remove it";
    ignored
        .map(|(index, _)| Finding::new(&file.path, index + 1, "an ignored test", remedy))
        .collect()
}

/// Examples that the documentation's tests would skip.
fn check_examples(path: &str, text: &str) -> Vec<Finding> {
    let is_ignored = |line: &str| {
        let line = line.trim_start().trim_start_matches(['/', '!']).trim_start();
        let attributes = line.strip_prefix("```").unwrap_or_default();
        attributes.split(',').any(|attribute| attribute.trim() == "ignore")
    };
    let remedy = "make it compile, or mark it as `text`";
    let lines = text.lines().enumerate().filter(|(_, line)| is_ignored(line));
    lines.map(|(index, _)| Finding::new(path, index + 1, "an ignored example", remedy)).collect()
}

#[cfg(test)]
mod tests {
    use super::super::project::{Finding, Project};
    use super::check;

    fn findings(path: &str, text: &str) -> Vec<Finding> {
        check(&Project::in_memory(&[(path, text)]))
    }

    #[test]
    fn ignored_tests_and_examples_are_found() {
        for line in [
            "#[ignore]",
            "#[ignore = \"slow\"]",
            "#[cfg_attr(debug_assertions, ignore)]",
            "/// ```ignore",
            "//! ```rust,ignore",
        ] {
            let found = findings("crates/a/src/b.rs", &format!("\n{line}\n"));
            assert_eq!(found.len(), 1, "{line}");
            assert!(found[0].message("r").starts_with("crates/a/src/b.rs:2: r: "), "{line}");
        }
        assert_eq!(findings("crates/a/README.md", "```ignore\n").len(), 1);
    }

    #[test]
    fn words_in_text_and_longer_names_are_fine() {
        for line in ["// #[ignore]", "let s = \"#[ignore]\";", "/// ```text", "let ignore = 1;"] {
            assert_eq!(findings("crates/a/src/b.rs", line), [], "{line}");
        }
    }
}
