//! `cargo xtask tidy`: the rules of the workspace that no compiler lint knows.
//!
//! One file a rule; [`RULES`] registers them. A rule sees the project in memory only, so that each
//! is tested with an example it accepts and one it refuses.

mod absolute_paths;
mod crate_edges;
mod crate_manifest;
mod crate_readme;
mod crate_weight;
mod file_head;
mod fixture_readme;
mod half_written;
mod import_order;
mod library_root;
mod lost_file;
mod module_name;
mod module_tree;
mod pages;
mod private_words;
mod project;
mod rust_code;
mod size;
mod spread_name;
mod test_binary;
mod top_level;
mod unfinished;
mod unit_suffix;
mod use_path;

use anyhow::{Result, ensure};
use clap::{Arg, ArgAction, Command};

use self::project::{Finding, Project, RustFile};
use self::use_path::listed;

/// The task's name, help and options.
pub(crate) fn task() -> Command {
    let list = Arg::new("list")
        .long("list")
        .action(ArgAction::SetTrue)
        .help("Print the rules instead of checking them");
    Command::new("tidy")
        .about("Check the rules of the workspace that no compiler lint knows")
        .arg(list)
}

/// Prints the rules.
pub(crate) fn list() {
    RULES.iter().for_each(|rule| println!("{}: {}", rule.name, rule.demand));
}

/// Prints every finding as `path:line: rule: what is wrong; what to do`.
///
/// # Errors
/// When there is a finding, or the project cannot be read.
pub(crate) fn run() -> Result<()> {
    let project = Project::load()?;
    let messages = check(&project);
    messages.iter().for_each(|message| println!("{message}"));
    ensure!(messages.is_empty(), "tidy found {} to mend", messages.len());
    println!("tidy: {} rules hold on {} files", RULES.len(), project.n_files());
    Ok(())
}

/// The files that lists such as `catalogue! { tilt::Tilt, }` declare.
///
/// # Errors
/// A project that cannot be read.
pub(crate) fn listed_files() -> Result<Vec<String>> {
    Ok(listed_in(&Project::load()?))
}

fn listed_in(project: &Project) -> Vec<String> {
    let of = |file: &RustFile| {
        let folder = file.path.trim_end_matches(".rs").trim_end_matches("/mod").to_owned();
        let place = |(module, _): (&str, &str)| format!("{folder}/{module}.rs");
        let names = listed(&file.code).filter_map(|entry| entry.split_once("::"));
        names.map(place).filter(|path| project.text(path).is_some()).collect::<Vec<_>>()
    };
    project.rust_files().iter().flat_map(of).collect()
}

/// What the project must look like, and how that is checked.
struct Rule {
    name: &'static str,
    demand: &'static str,
    check: fn(&Project) -> Vec<Finding>,
}

const RULES: &[Rule] = &[
    absolute_paths::RULE,
    crate_edges::RULE,
    crate_manifest::RULE,
    crate_readme::RULE,
    crate_weight::RULE,
    file_head::RULE,
    fixture_readme::RULE,
    half_written::RULE,
    import_order::RULE,
    library_root::RULE,
    lost_file::RULE,
    module_name::RULE,
    pages::RULE,
    private_words::RULE,
    size::RULE,
    spread_name::RULE,
    test_binary::RULE,
    top_level::RULE,
    unfinished::RULE,
    unit_suffix::RULE,
];

fn check(project: &Project) -> Vec<String> {
    let messages = |rule: &Rule| {
        let findings = (rule.check)(project);
        findings.into_iter().map(|finding| finding.message(rule.name)).collect::<Vec<_>>()
    };
    RULES.iter().flat_map(messages).collect()
}

#[cfg(test)]
mod tests {
    use super::project::{Crate, Project};
    use super::{RULES, check, listed_in};

    const MANIFEST: &str = "[package]\nname = \"planar\"\n\n[lints]\nworkspace = true\n";
    const LIBRARY: &str = "#![doc = include_str!(\"../README.md\")]\n\n\
        mod pose;\n\npub use pose::Pose;\n";
    const README: &str = "# planar\n\n```rust\nassert_eq!(1 + 1, 2);\n```\n";

    fn clean_project() -> Project {
        let planar = Crate {
            name: "planar".into(),
            folder: "crates/planar".into(),
            is_library: true,
            has_doctests: true,
            roots: vec!["crates/planar/src/lib.rs".into()],
            ..Crate::default()
        };
        Project::in_memory(&[
            ("Cargo.toml", "[workspace]\n"),
            ("ARCHITECTURE.md", "| crate | imports (ours) |\n|---|---|\n| `planar` | – |\n"),
            ("README.md", "# pushlab\n"),
            ("docs/SUMMARY.md", "- [Glossary](glossary.md)\n"),
            ("docs/glossary.md", "| not | but |\n|---|---|\n| told | reported |\n"),
            ("crates/planar/Cargo.toml", MANIFEST),
            ("crates/planar/README.md", README),
            ("crates/planar/src/lib.rs", LIBRARY),
            ("crates/planar/src/pose.rs", "//! Poses.\n\n/// A pose.\npub struct Pose;\n"),
            ("fixtures/abs/README.md", "# Abs\n"),
        ])
        .with_crates(vec![planar])
    }

    #[test]
    fn a_clean_project_has_no_findings() {
        assert_eq!(check(&clean_project()), Vec::<String>::new());
    }

    #[test]
    fn files_that_a_list_declares_are_found() {
        let project = Project::in_memory(&[
            (
                "crates/a/src/roofs/mod.rs",
                "//! R.\nroofs! {\n    old {\n        red::R,\n        lost::L,\n    }\n}\n",
            ),
            ("crates/a/src/roofs/red.rs", "//! Red.\n"),
        ]);
        assert_eq!(listed_in(&project), ["crates/a/src/roofs/red.rs"]);
    }

    #[test]
    fn a_message_names_place_rule_fault_and_remedy() {
        let project = Project::in_memory(&[("notes.txt", "")]);
        assert_eq!(
            check(&project),
            ["notes.txt:1: top-level: `notes.txt` has no place at the top level; \
              move it under crates, xtask, fixtures or docs"]
        );
    }

    #[test]
    fn rules_are_registered_once_and_in_order() {
        assert!(RULES.is_sorted_by(|a, b| a.name < b.name));
    }
}
