//! A library crate's README is its crate documentation, with an example that is a doctest or with no code.

use super::Rule;
use super::project::{Crate, Finding, Project};

pub(super) const RULE: Rule = Rule {
    name: "crate-readme",
    demand: "a library's README is its crate documentation and has a Rust example, or none without doctests",
    check,
};

fn check(project: &Project) -> Vec<Finding> {
    let libraries = project.crates().iter().filter(|member| member.is_library);
    libraries.flat_map(|library| check_library(project, library)).collect()
}

fn check_library(project: &Project, library: &Crate) -> Vec<Finding> {
    let readme = format!("{}/README.md", library.folder);
    let root = format!("{}/src/lib.rs", library.folder);
    let mut findings = Vec::new();
    let has_example = |text: &str| text.lines().any(|line| line == "```rust");
    let fault = match (library.has_doctests, project.text(&readme).is_some_and(has_example)) {
        (true, false) => Some(("no example that is a doctest", "add ten lines in a ```rust block")),
        (false, true) => {
            Some(("an example that nothing compiles", "remove it, or `doctest = false`"))
        }
        _ => None,
    };
    findings.extend(fault.map(|(fault, remedy)| Finding::new(&readme, 1, fault, remedy)));
    let includes = "#![doc = include_str!(\"../README.md\")]";
    if !project.text(&root).is_some_and(|text| text.lines().any(|line| line == includes)) {
        let fault = "the README is not the crate's documentation";
        findings.push(Finding::new(&root, 1, fault, format!("begin with `{includes}`")));
    }
    findings
}

#[cfg(test)]
mod tests {
    use super::super::project::{Crate, Finding, Project};
    use super::check;

    fn findings(has_doctests: bool, files: &[(&str, &str)]) -> Vec<Finding> {
        let folder = "crates/planar".into();
        let member = Crate { folder, is_library: true, has_doctests, ..Crate::default() };
        check(&Project::in_memory(files).with_crates(vec![member]))
    }

    #[test]
    fn a_readme_with_an_example_is_fine() {
        let lib = "#![doc = include_str!(\"../README.md\")]\n";
        let readme = "# planar\n\n```rust\nuse planar::Pose;\n```\n";
        let files = [("crates/planar/README.md", readme), ("crates/planar/src/lib.rs", lib)];
        assert_eq!(findings(true, &files), []);
        let messages: Vec<_> = findings(false, &files).iter().map(|it| it.message("r")).collect();
        assert!(messages[0].starts_with("crates/planar/README.md:1: r: an example that nothing"));
    }

    #[test]
    fn an_example_that_does_not_run_and_a_readme_not_included_are_found() {
        let readme = "# planar\n\n```rust,ignore\nx\n```\n";
        let files = [("crates/planar/README.md", readme), ("crates/planar/src/lib.rs", "//! P.\n")];
        let messages: Vec<_> = findings(true, &files).iter().map(|it| it.message("r")).collect();
        assert!(messages[0].starts_with("crates/planar/README.md:1: r: no example"));
        assert!(messages[1].starts_with("crates/planar/src/lib.rs:1: r: the README is not"));
    }
}
