//! A module is named after what it holds.

use super::Rule;
use super::project::{Finding, Project, RustFile};

pub(super) const RULE: Rule =
    Rule { name: "module-name", demand: "modules are named after what they hold", check };

const MEANINGLESS: &[&str] = &["util", "utils", "common", "misc", "types", "prelude", "helpers"];

fn check(project: &Project) -> Vec<Finding> {
    project.rust_files().iter().flat_map(check_file).collect()
}

fn check_file(file: &RustFile) -> Vec<Finding> {
    let parts = file.path.trim_end_matches(".rs").split('/').map(|part| (1, part));
    let words: Vec<_> = file.words().filter(|(_, word)| !word.is_empty()).collect();
    let modules = words.windows(2).filter(|pair| pair[0].1 == "mod").map(|pair| pair[1]);
    let bad = parts.chain(modules).filter(|(_, name)| MEANINGLESS.contains(name));
    let finding = |(line, name)| {
        let fault = format!("`{name}` says nothing about what it holds");
        Finding::new(&file.path, line, fault, "name it after its one noun, or move it to its user")
    };
    bad.map(finding).collect()
}

#[cfg(test)]
mod tests {
    use super::super::project::{Finding, Project};
    use super::check;

    fn findings(path: &str, code: &str) -> Vec<Finding> {
        check(&Project::in_memory(&[(path, code)]))
    }

    #[test]
    fn a_noun_is_fine() {
        let code = "mod pose;\nuse proptest::prelude::proptest;\nlet types = 1;\n";
        assert_eq!(findings("crates/a/src/lib.rs", code), []);
    }

    #[test]
    fn files_folders_and_modules_that_say_nothing_are_found() {
        assert_eq!(findings("crates/a/src/utils.rs", "").len(), 1);
        assert_eq!(findings("crates/a/tests/common/mod.rs", "").len(), 1);
        assert!(
            findings("crates/a/src/b.rs", "//! B.\n\nmod types {}\n")[0]
                .message("r")
                .starts_with("crates/a/src/b.rs:3: r: `types` says nothing")
        );
    }
}
