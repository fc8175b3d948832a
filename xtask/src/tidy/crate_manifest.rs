//! A crate's manifest says what a user of the crate alone wants to know.

use super::Rule;
use super::project::{Crate, Finding, Project};

pub(super) const RULE: Rule = Rule {
    name: "crate-manifest",
    demand: "a crate has its folder's name, full package metadata and the workspace's lints",
    check,
};

fn check(project: &Project) -> Vec<Finding> {
    project.crates().iter().flat_map(|member| check_crate(project, member)).collect()
}

fn check_crate(project: &Project, member: &Crate) -> Vec<Finding> {
    let manifest = member.manifest();
    let found = |fault: String, remedy: String| Finding::new(&manifest, 1, fault, remedy);
    let mut findings = Vec::new();
    if member.folder.rsplit('/').next() != Some(&member.name) {
        let fault = format!("the crate `{}` lies in `{}`", member.name, member.folder);
        findings.push(found(fault, "give crate and folder one name".into()));
    }
    for key in &member.unset_keys {
        findings.push(found(format!("`{key}` is not set"), format!("set `{key}` under [package]")));
    }
    let text = project.text(&manifest).unwrap_or_default();
    if !text.contains("[lints]\nworkspace = true") {
        let remedy = "add `[lints]` with `workspace = true`";
        findings.push(found("the workspace's lints are not inherited".into(), remedy.into()));
    }
    findings
}

#[cfg(test)]
mod tests {
    use super::super::project::{Crate, Project};
    use super::check;

    fn faults(folder: &str, unset_keys: Vec<&'static str>, manifest: &str) -> Vec<String> {
        let member =
            Crate { name: "planar".into(), folder: folder.into(), unset_keys, ..Crate::default() };
        let project = Project::in_memory(&[(&member.manifest(), manifest)]);
        check(&project.with_crates(vec![member])).iter().map(|found| found.message("r")).collect()
    }

    #[test]
    fn a_full_manifest_is_fine() {
        let found = faults("crates/planar", vec![], "[package]\n\n[lints]\nworkspace = true\n");
        assert_eq!(found, Vec::<String>::new());
    }

    #[test]
    fn a_foreign_folder_an_unset_key_and_missing_lints_are_found() {
        let found = faults("crates/plane", vec!["license"], "[package]\n");
        assert_eq!(
            found,
            [
                "crates/plane/Cargo.toml:1: r: the crate `planar` lies in `crates/plane`; \
                 give crate and folder one name",
                "crates/plane/Cargo.toml:1: r: `license` is not set; set `license` under [package]",
                "crates/plane/Cargo.toml:1: r: the workspace's lints are not inherited; \
                 add `[lints]` with `workspace = true`",
            ]
        );
    }
}
