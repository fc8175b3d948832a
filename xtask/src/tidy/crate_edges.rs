//! Which crate may import which: the architecture's table.

use super::Rule;
use super::project::{Crate, Finding, Project};

pub(super) const RULE: Rule = Rule {
    name: "crate-edges",
    demand: "crates import only what the architecture's table allows",
    check,
};

/// Each crate and the workspace crates that it may import, in any dependency table.
///
/// `plant` reaches none of `mechanics`, `effects`, `models` and `diagnosis`: a diagnosis tested on
/// its own formulas proves nothing.
const ALLOWED: &[(&str, &[&str])] = &[
    ("planar", &[]),
    ("mechanics", &["planar"]),
    ("effects", &["planar", "mechanics"]),
    ("output", &[]),
    ("dataset", &["planar", "output"]),
    ("gp-core", &[]),
    ("gp-sparse", &["gp-core"]),
    ("gp-rff", &["gp-core"]),
    ("filter", &[]),
    (
        "models",
        &[
            "planar",
            "mechanics",
            "effects",
            "gp-core",
            "gp-sparse",
            "gp-rff",
            "filter",
            "dataset",
            "output",
        ],
    ),
    ("plant", &["planar", "dataset", "output"]),
    ("diagnosis", &["planar", "mechanics", "effects", "models", "dataset", "gp-core"]),
    ("report", &["output"]),
    ("pushlab", LIBRARIES),
    (
        "validation",
        &["planar", "mechanics", "effects", "dataset", "models", "plant", "diagnosis", "output"],
    ),
    ("studies", LIBRARIES_AND_VALIDATION),
    ("benchmarks", LIBRARIES_AND_VALIDATION),
    ("fuzzing", &["planar", "effects", "dataset", "gp-core", "models", "diagnosis", "output"]),
    ("xtask", &[]),
];

const LIBRARIES_AND_VALIDATION: &[&str] = &[
    "validation",
    "planar",
    "mechanics",
    "effects",
    "dataset",
    "gp-core",
    "gp-sparse",
    "gp-rff",
    "filter",
    "models",
    "plant",
    "diagnosis",
    "report",
    "output",
];

const LIBRARIES: &[&str] = LIBRARIES_AND_VALIDATION.split_at(1).1;

fn check(project: &Project) -> Vec<Finding> {
    project.crates().iter().flat_map(|member| check_crate(project, member)).collect()
}

fn check_crate(project: &Project, member: &Crate) -> Vec<Finding> {
    let manifest = member.manifest();
    let Some((_, allowed)) = ALLOWED.iter().find(|(name, _)| *name == member.name) else {
        let fault = format!("`{}` is not in the table of crates", member.name);
        let remedy = "decide what it may import and add it to ARCHITECTURE.md and this rule";
        return vec![Finding::new(&manifest, 1, fault, remedy)];
    };
    let forbidden = member.imports.iter().filter(|import| !allowed.contains(&import.as_str()));
    let finding = |import: &String| {
        let declares = |line: &str| line.split(['.', '=', ' ']).next() == Some(import);
        let text = project.text(&manifest).unwrap_or_default();
        let line = text.lines().position(declares).map_or(1, |index| index + 1);
        let fault = format!("`{}` may not import `{import}`", member.name);
        Finding::new(&manifest, line, fault, "move the code that needs it to a crate that may")
    };
    forbidden.map(finding).collect()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::super::project::{Crate, Project};
    use super::{ALLOWED, check};

    fn messages(name: &str, imports: &[&str], manifest: &str) -> Vec<String> {
        let folder = format!("crates/{name}");
        let imports = imports.iter().map(|&import| import.into()).collect();
        let member =
            Crate { name: name.into(), folder: folder.clone(), imports, ..Crate::default() };
        let project = Project::in_memory(&[(&format!("{folder}/Cargo.toml"), manifest)]);
        check(&project.with_crates(vec![member])).iter().map(|found| found.message("r")).collect()
    }

    #[test]
    fn an_edge_outside_the_table_is_found_where_it_is_declared() {
        let manifest = "[dependencies]\nplanar.workspace = true\nmechanics.workspace = true\n";
        assert_eq!(
            messages("plant", &["planar", "mechanics"], manifest),
            ["crates/plant/Cargo.toml:3: r: `plant` may not import `mechanics`; \
              move the code that needs it to a crate that may"]
        );
    }

    #[test]
    fn edges_of_the_table_are_fine() {
        assert_eq!(messages("mechanics", &["planar"], ""), Vec::<String>::new());
    }

    #[test]
    fn a_crate_outside_the_table_is_found() {
        assert!(messages("tools", &[], "")[0].contains("`tools` is not in the table"));
    }

    fn reached(name: &str) -> BTreeSet<&'static str> {
        let (_, imports) = ALLOWED.iter().find(|row| row.0 == name).expect("a crate of the table");
        imports.iter().flat_map(|import| reached(import).into_iter().chain([*import])).collect()
    }

    #[test]
    fn no_crate_of_the_table_reaches_itself() {
        for (name, _) in ALLOWED {
            assert!(!reached(name).contains(name), "{name}");
        }
    }

    #[test]
    fn the_checks_wait_for_no_crate_of_ours() {
        assert!(reached("xtask").is_empty());
    }

    #[test]
    fn the_simulator_reaches_no_formula_that_it_tests() {
        let formulas = BTreeSet::from(["mechanics", "effects", "models", "diagnosis"]);
        assert!(reached("plant").is_disjoint(&formulas));
    }
}
