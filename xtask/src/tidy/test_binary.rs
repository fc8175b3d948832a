//! A crate's integration tests are one program.

use super::Rule;
use super::project::{Crate, Finding, Project};

pub(super) const RULE: Rule = Rule {
    name: "test-binary",
    demand: "a crate's integration tests are one program, `tests/it/main.rs`, so that it links once",
    check,
};

fn check(project: &Project) -> Vec<Finding> {
    project.crates().iter().flat_map(check_crate).collect()
}

fn check_crate(member: &Crate) -> Vec<Finding> {
    let root = format!("{}/tests/it/main.rs", member.folder);
    let others = member.test_roots.iter().filter(|path| **path != root);
    let finding = |path: &String| {
        let remedy = format!("make it a module of `{root}`");
        Finding::new(path, 1, "a program of integration tests of its own", remedy)
    };
    others.map(finding).collect()
}

#[cfg(test)]
mod tests {
    use super::super::project::{Crate, Project};
    use super::check;

    fn messages(test_roots: &[&str]) -> Vec<String> {
        let test_roots = test_roots.iter().map(|&path| path.into()).collect();
        let member = Crate { folder: "crates/a".into(), test_roots, ..Crate::default() };
        let project = Project::in_memory(&[]).with_crates(vec![member]);
        check(&project).iter().map(|found| found.message("r")).collect()
    }

    #[test]
    fn one_program_or_none_is_fine() {
        assert_eq!(messages(&[]), Vec::<String>::new());
        assert_eq!(messages(&["crates/a/tests/it/main.rs"]), Vec::<String>::new());
    }

    #[test]
    fn a_second_program_is_found() {
        assert_eq!(
            messages(&["crates/a/tests/it/main.rs", "crates/a/tests/laws.rs"]),
            ["crates/a/tests/laws.rs:1: r: a program of integration tests of its own; \
              make it a module of `crates/a/tests/it/main.rs`"]
        );
    }
}
