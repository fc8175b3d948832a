//! The top level stays a table of contents.

use std::collections::BTreeSet;

use super::Rule;
use super::project::{Finding, Project};

pub(super) const RULE: Rule =
    Rule { name: "top-level", demand: "the top level has its known names only", check };

const NAMES: &[&str] = &[
    ".cargo",
    ".ci",
    ".gitignore",
    "ARCHITECTURE.md",
    "CHANGELOG.md",
    "CONTRIBUTING.md",
    "Cargo.lock",
    "Cargo.toml",
    "LICENSE",
    "README.md",
    "clippy.toml",
    "crates",
    "docs",
    "fixtures",
    "rustfmt.toml",
    "xtask",
];

fn check(project: &Project) -> Vec<Finding> {
    let names: BTreeSet<_> = project.paths().filter_map(|path| path.split('/').next()).collect();
    let finding = |name: &str| {
        let fault = format!("`{name}` has no place at the top level");
        Finding::new(name, 1, fault, "move it under crates, xtask, fixtures or docs")
    };
    names.into_iter().filter(|name| !NAMES.contains(name)).map(finding).collect()
}

#[cfg(test)]
mod tests {
    use super::super::project::Project;
    use super::check;

    #[test]
    fn known_names_are_fine() {
        let files = [("LICENSE", ""), ("docs/notes/a.md", ""), (".ci/run", "")];
        assert_eq!(check(&Project::in_memory(&files)), []);
    }

    #[test]
    fn a_new_name_is_found_once() {
        let files = [("scripts/a.sh", ""), ("scripts/b.sh", "")];
        assert_eq!(check(&Project::in_memory(&files)).len(), 1);
    }
}
