//! No file is written in place: a killed run would leave half of it.

use super::Rule;
use super::project::{Finding, Project, RustFile};
use super::size::lines_without_tests;

pub(super) const RULE: Rule = Rule {
    name: "half-written",
    demand: "files and folders are written by the crate `output` alone",
    check,
};

const CALLS: &[&str] = &["fs::write(", "fs::rename(", "fs::copy(", "File::create", ".persist("];

/// Where they may stand, each with the reason why no half file can be left.
const EXCEPTIONS: &[(&str, &str)] = &[
    ("crates/output/src/", "it is what makes them whole"),
    ("crates/fuzzing/src/reader.rs", "writes into its scratch folder, which goes with it"),
    ("crates/fuzzing/src/readers/", "write into their scratch folders, which go with them"),
    ("crates/fuzzing/src/watch.rs", "writes into its scratch folder, which goes with it"),
    ("crates/fuzzing/src/worker.rs", "writes into its scratch folder, which goes with it"),
    ("crates/validation/src/trials/trial.rs", "moves a whole set away from its truth"),
];

fn check(project: &Project) -> Vec<Finding> {
    let is_checked = |file: &&RustFile| {
        let is_source = file.path.contains("/src/") && !file.path.ends_with("/tests.rs");
        is_source && !EXCEPTIONS.iter().any(|(exception, _)| file.path.starts_with(exception))
    };
    project.rust_files().iter().filter(is_checked).flat_map(check_file).collect()
}

fn check_file(file: &RustFile) -> Vec<Finding> {
    let lines = file.code.lines().take(lines_without_tests(&file.code)).enumerate();
    let finding = |(index, line): (usize, &str)| {
        let call = CALLS.iter().find(|call| line.contains(*call))?;
        let fault = format!("`{}` can leave half a file", call.trim_matches(['.', '(']));
        Some(Finding::new(&file.path, index + 1, fault, "write it by `output`"))
    };
    lines.filter_map(finding).collect()
}

#[cfg(test)]
mod tests {
    use super::super::project::{Finding, Project};
    use super::check;

    fn findings(path: &str, text: &str) -> Vec<Finding> {
        check(&Project::in_memory(&[(path, text)]))
    }

    #[test]
    fn writing_in_place_is_found() {
        for line in ["std::fs::write(path, text)?;", "fs::rename(&a, &b)", "File::create(p)?"] {
            let found = findings("crates/a/src/b.rs", &format!("\n{line}\n"));
            assert!(found[0].message("r").starts_with("crates/a/src/b.rs:2: r: `"), "{line}");
        }
    }

    #[test]
    fn tests_reading_and_whole_files_are_fine() {
        let call = "fs::write(path, text);\n";
        let tests = format!("#[cfg(test)]\nmod tests {{\n{call}}}\n");
        assert_eq!(findings("crates/a/src/b.rs", &tests), []);
        assert_eq!(findings("crates/a/tests/laws.rs", call), []);
        assert_eq!(findings("crates/a/src/b/tests.rs", call), []);
        assert_eq!(findings("crates/output/src/file.rs", call), []);
        for line in ["fs::read(path)", "output::write(path, text)?;", "// fs::write(a, b)"] {
            assert_eq!(findings("crates/a/src/b.rs", line), [], "{line}");
        }
    }
}
