//! Every fixture folder says where its data come from.

use std::collections::BTreeSet;

use super::Rule;
use super::project::{Finding, Project};

pub(super) const RULE: Rule =
    Rule { name: "fixture-readme", demand: "every folder of fixtures has a README.md", check };

fn check(project: &Project) -> Vec<Finding> {
    let inside = project.paths().filter_map(|path| path.strip_prefix("fixtures/")?.split_once('/'));
    let folders: BTreeSet<_> = inside.map(|(folder, _)| folder).collect();
    let readmes = folders.into_iter().map(|folder| format!("fixtures/{folder}/README.md"));
    let missing =
        readmes.filter(|readme| project.text(readme).is_none_or(|text| text.trim().is_empty()));
    let remedy = "state origin, licence, units, frames and the command that made it";
    missing.map(|readme| Finding::new(&readme, 1, "missing or empty", remedy)).collect()
}

#[cfg(test)]
mod tests {
    use super::super::project::Project;
    use super::check;

    #[test]
    fn a_folder_with_a_readme_is_fine() {
        let files = [("fixtures/gp/README.md", "# GP\n"), ("fixtures/gp/a/b.csv", "1\n")];
        assert_eq!(check(&Project::in_memory(&files)), []);
    }

    #[test]
    fn a_folder_without_one_or_with_an_empty_one_is_found() {
        let files = [("fixtures/gp/a/README.md", "# A\n"), ("fixtures/abs/README.md", "\n")];
        let findings = check(&Project::in_memory(&files));
        let messages: Vec<_> = findings.iter().map(|found| found.message("r")).collect();
        assert_eq!(messages.len(), 2);
        assert!(messages[0].starts_with("fixtures/abs/README.md:1: r: missing or empty"));
        assert!(messages[1].starts_with("fixtures/gp/README.md:1: r: missing or empty"));
    }
}
