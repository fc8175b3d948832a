//! Pages are found from the book's table of contents, and their links lead somewhere.

use std::collections::BTreeSet;
use std::path::{Component, Path};

use super::Rule;
use super::project::{Finding, Project};

pub(super) const RULE: Rule = Rule {
    name: "pages",
    demand: "links of pages lead to files, and docs/SUMMARY.md lists every page of docs",
    check,
};

const CONTENTS: &str = "docs/SUMMARY.md";

fn check(project: &Project) -> Vec<Finding> {
    let pages = project.texts().filter(|(path, _)| path.ends_with(".md"));
    let dead = pages.flat_map(|(path, text)| {
        let targets = targets(text);
        let dead = targets.into_iter().filter(|(_, target)| !leads(project, path, target));
        dead.map(move |(line, target)| {
            let fault = format!("there is no `{target}`");
            Finding::new(path, line, fault, "correct the link, or take it out")
        })
    });
    dead.chain(unlisted(project)).collect()
}

/// Relative targets of the links of a page, without anchors; lines counted from 1.
fn targets(page: &str) -> Vec<(usize, &str)> {
    let mut is_code = false;
    let mut found = Vec::new();
    for (index, line) in page.lines().enumerate() {
        is_code ^= line.trim_start().starts_with("```");
        let links = line.split("](").skip(1).filter_map(|rest| rest.split_once(')'));
        let targets = links.map(|(target, _)| target.split('#').next().unwrap_or(target));
        let is_file = |target: &&str| !target.is_empty() && !target.contains("://") && !is_code;
        found.extend(targets.filter(is_file).map(|target| (index + 1, target)));
    }
    found
}

/// Whether a target is a file or a folder of the project.
fn leads(project: &Project, page: &str, target: &str) -> bool {
    let Some(path) = resolved(page, target) else { return false };
    let is_folder = |file: &str| file.strip_prefix(&path).is_some_and(|rest| rest.starts_with('/'));
    project.paths().any(|file| file == path || is_folder(file))
}

/// A target from the root of the project; none if it leads out of it.
fn resolved(page: &str, target: &str) -> Option<String> {
    let mut parts: Vec<&str> = page.split('/').collect();
    parts.pop();
    for component in Path::new(target).components() {
        match component {
            Component::ParentDir => drop(parts.pop()?),
            Component::Normal(part) => parts.push(part.to_str()?),
            Component::CurDir => {}
            Component::RootDir | Component::Prefix(_) => return None,
        }
    }
    Some(parts.join("/"))
}

fn unlisted(project: &Project) -> Vec<Finding> {
    let contents = project.text(CONTENTS).unwrap_or_default();
    let listed: BTreeSet<_> = targets(contents)
        .into_iter()
        .filter_map(|(_, target)| resolved(CONTENTS, target))
        .collect();
    let is_page = |path: &&str| {
        let name = path.strip_prefix("docs/").unwrap_or_default();
        name.ends_with(".md") && !name.contains('/') && *path != CONTENTS
    };
    let unlisted = project.paths().filter(is_page).filter(|path| !listed.contains(*path));
    let finding =
        |path| Finding::new(path, 1, "no chapter of the book", "list it in docs/SUMMARY.md");
    unlisted.map(finding).collect()
}

#[cfg(test)]
mod tests {
    use super::super::project::Project;
    use super::check;

    fn messages(files: &[(&str, &str)]) -> Vec<String> {
        check(&Project::in_memory(files)).iter().map(|found| found.message("r")).collect()
    }

    #[test]
    fn links_to_files_folders_places_and_other_sites_are_fine() {
        let page =
            "[a](../LICENSE) [b](b.md#part) [c](#here) [d](https://e.org) [e](../crates/e)\n";
        let files = [
            ("fixtures/a.md", page),
            ("fixtures/b.md", ""),
            ("LICENSE", ""),
            ("crates/e/a.rs", ""),
        ];
        assert!(messages(&files).is_empty());
    }

    #[test]
    fn links_that_lead_nowhere_are_found() {
        assert_eq!(
            messages(&[("fixtures/a.md", "\n[b](b.md) [c](../../c)\n")]),
            [
                "fixtures/a.md:2: r: there is no `b.md`; correct the link, or take it out",
                "fixtures/a.md:2: r: there is no `../../c`; correct the link, or take it out"
            ]
        );
        assert!(messages(&[("fixtures/a.md", "```rust\na[1](b)\n```\n")]).is_empty());
    }

    #[test]
    fn pages_that_the_book_does_not_list_are_found() {
        let files = [("docs/SUMMARY.md", "- [A](a.md)\n"), ("docs/a.md", ""), ("docs/b.md", "")];
        assert_eq!(
            messages(&files),
            ["docs/b.md:1: r: no chapter of the book; list it in docs/SUMMARY.md"]
        );
        assert_eq!(messages(&[("docs/a.md", "")]).len(), 1);
    }
}
