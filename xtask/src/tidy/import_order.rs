//! Imports within a crate run one way.

use std::collections::{BTreeMap, BTreeSet};

use super::Rule;
use super::module_tree::{Imports, ModuleTree};
use super::project::{Finding, Project};

pub(super) const RULE: Rule = Rule {
    name: "import-order",
    demand: "no files of a crate import each other in a circle, and none imports from a later group of \
             its root's `mod` lines",
    check,
};

fn check(project: &Project) -> Vec<Finding> {
    // A library and its program stand in one folder: what both roots show is told once.
    let roots = project.crates().iter().flat_map(|one| &one.roots);
    let mut findings: Vec<Finding> = Vec::new();
    for finding in roots.flat_map(|root| check_root(project, root)) {
        if !findings.contains(&finding) {
            findings.push(finding);
        }
    }
    findings
}

fn check_root(project: &Project, root: &str) -> Vec<Finding> {
    let tree = ModuleTree::of(project, root);
    let imports = tree.imports();
    let mut findings = circles(&tree, &imports);
    let Some(text) = project.text(root) else { return findings };
    let order = groups(text);
    let group = |module: &str| order.get(module.split("::").next().unwrap_or_default());
    for (module, others) in &imports {
        for (other, line) in others {
            if group(module) < group(other) && group(module).is_some() {
                let fault = format!("imports {other}, which comes later in {root}");
                let remedy = "move what it needs down, or itself up";
                findings.push(Finding::new(&tree.file(module).path, *line, fault, remedy));
            }
        }
    }
    findings
}

/// One finding for each circle.
fn circles(tree: &ModuleTree<'_>, imports: &Imports) -> Vec<Finding> {
    let reached: BTreeMap<&str, BTreeSet<&str>> =
        imports.keys().map(|module| (module.as_str(), reached(imports, module))).collect();
    let mut findings = Vec::new();
    let mut told: BTreeSet<&str> = BTreeSet::new();
    for (module, others) in &reached {
        if told.contains(module) || !others.contains(module) {
            continue;
        }
        let circle: Vec<&str> =
            others.iter().copied().filter(|other| reached[other].contains(module)).collect();
        told.extend(&circle);
        let within = |(other, _): &(&String, &usize)| circle.contains(&other.as_str());
        let line = imports[*module].iter().find(within).map_or(1, |(_, line)| *line);
        let fault = format!("{} import each other in a circle", circle.join(", "));
        let remedy = "move what both sides need to a file of its own";
        findings.push(Finding::new(&tree.file(module).path, line, fault, remedy));
    }
    findings
}

/// All modules that one leads to by imports.
fn reached<'a>(imports: &'a Imports, from: &'a str) -> BTreeSet<&'a str> {
    let mut found: BTreeSet<&str> = BTreeSet::new();
    let mut open: Vec<&str> = vec![from];
    while let Some(module) = open.pop() {
        let next = imports.get(module).into_iter().flat_map(BTreeMap::keys);
        open.extend(next.map(String::as_str).filter(|other| found.insert(other)));
    }
    found
}

/// The group of each module: `mod` lines with nothing but attributes and comments between them.
fn groups(root: &str) -> BTreeMap<&str, usize> {
    let (mut number, mut found) = (0, BTreeMap::new());
    for line in root.lines() {
        let declared = line.trim_start_matches("pub ").strip_prefix("mod ");
        match declared.and_then(|rest| rest.strip_suffix(';')) {
            Some(name) => {
                found.insert(name, number);
            }
            None if line.starts_with("#[") || line.starts_with("//") => {}
            None => number += 1,
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::super::project::{Crate, Finding, Project};
    use super::check;

    fn findings(files: &[(&str, &str)]) -> Vec<Finding> {
        let roots = vec!["crates/a/src/lib.rs".to_owned()];
        let one = Crate { name: "a".into(), roots, ..Crate::default() };
        check(&Project::in_memory(files).with_crates(vec![one]))
    }

    #[test]
    fn imports_down_the_list_and_from_a_folders_face_are_fine() {
        let root = "mod ground;\n\nmod house;\nmod roof;\n\npub use ground::G;\n";
        let found = findings(&[
            ("crates/a/src/lib.rs", root),
            ("crates/a/src/ground.rs", "//! Ground.\npub struct G;\n"),
            ("crates/a/src/house/mod.rs", "//! H.\nmod room;\nuse self::room::R;\nuse crate::G;\n"),
            ("crates/a/src/house/room.rs", "//! Room.\nuse super::H;\n"),
            ("crates/a/src/roof.rs", "//! Roof.\nuse crate::house::H;\n"),
        ]);
        assert_eq!(found, []);
    }

    #[test]
    fn an_import_from_a_later_group_is_found_also_through_the_root() {
        let found = findings(&[
            ("crates/a/src/lib.rs", "mod ground;\n\nmod roof;\n\npub use roof::R;\n"),
            ("crates/a/src/ground.rs", "//! Ground.\n\nuse crate::R;\n"),
            ("crates/a/src/roof.rs", "//! Roof.\npub struct R;\n"),
        ]);
        let message = found[0].message("r");
        assert!(message.starts_with("crates/a/src/ground.rs:3: r: imports roof"), "{message}");
        assert_eq!(found.len(), 1);
    }

    #[test]
    fn an_import_through_a_list_that_the_root_hands_on_whole_is_found() {
        let found = findings(&[
            ("crates/a/src/lib.rs", "mod ground;\n\nmod roofs;\n\npub use roofs::*;\n"),
            ("crates/a/src/ground.rs", "//! Ground.\n\nuse crate::R;\nuse crate::all;\n"),
            (
                "crates/a/src/roofs/mod.rs",
                "//! Roofs.\nroofs! {\n    red::R,\n}\npub fn all() {}\n",
            ),
            ("crates/a/src/roofs/red.rs", "//! Red.\npub struct R;\n"),
        ]);
        let messages: Vec<_> = found.iter().map(|finding| finding.message("r")).collect();
        assert_eq!(messages.len(), 2, "{messages:?}");
        assert!(messages[0].contains("imports roofs,"), "{messages:?}");
        assert!(messages[1].contains("imports roofs::red,"), "{messages:?}");
    }

    #[test]
    fn a_circle_is_found_once_and_tests_are_free() {
        let found = findings(&[
            ("crates/a/src/lib.rs", "mod b;\nmod c;\nmod d;\n"),
            ("crates/a/src/b.rs", "//! B.\n\nuse crate::c::C;\n"),
            ("crates/a/src/c.rs", "//! C.\nuse crate::b::B;\nfn f() { crate::d::f(); }\n"),
            ("crates/a/src/d.rs", "//! D.\n#[cfg(test)]\nmod tests {\n    use crate::b::B;\n}\n"),
        ]);
        let message = found[0].message("r");
        assert!(message.starts_with("crates/a/src/b.rs:3: r: b, c import each other"), "{message}");
        assert_eq!(found.len(), 1);
    }
}
