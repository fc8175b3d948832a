//! Every file with code is part of a program.

use super::Rule;
use super::project::{Finding, Project, RustFile};
use super::use_path::listed;

pub(super) const RULE: Rule =
    Rule { name: "lost-file", demand: "every file with code is declared by a module", check };

fn check(project: &Project) -> Vec<Finding> {
    let roots = project.crates().iter().flat_map(|one| one.roots.iter().chain(&one.test_roots));
    let roots: Vec<&String> = roots.collect();
    // Of packages outside of the workspace, too.
    let is_root = |path: &String| {
        roots.contains(&path) || path.ends_with("/src/lib.rs") || path.ends_with("/src/main.rs")
    };
    let files = project.rust_files().iter();
    let is_in_folder = |file: &&RustFile| {
        ["/src/", "/tests/"].iter().any(|folder| file.path.contains(folder)) && !is_root(&file.path)
    };
    let is_lost = |file: &&RustFile| {
        let Some((parent, name)) = place(&file.path) else { return false };
        !project.rust_files().iter().any(|other| {
            let is_above = is_root(&other.path) && folder(&other.path) == parent;
            (is_above || may_declare(&other.path, parent)) && declares(other, name)
        })
    };
    let finding = |file: &RustFile| {
        let fault = "no module declares it, so that nothing of it is compiled";
        Finding::new(&file.path, 1, fault.to_owned(), "declare it with `mod`, or remove it")
    };
    files.filter(is_in_folder).filter(is_lost).map(finding).collect()
}

/// The folder whose module declares a file, and the file's name as a module.
fn place(path: &str) -> Option<(&str, &str)> {
    let stem = path.strip_suffix("/mod.rs").or_else(|| path.strip_suffix(".rs"))?;
    stem.rsplit_once('/')
}

fn folder(path: &str) -> &str {
    path.rsplit_once('/').map_or("", |(folder, _)| folder)
}

fn may_declare(path: &str, folder: &str) -> bool {
    let own = ["/mod.rs", ".rs"];
    own.iter().any(|end| path.strip_suffix(end) == Some(folder))
}

fn declares(file: &RustFile, name: &str) -> bool {
    let words: Vec<&str> = file.words().map(|(_, word)| word).collect();
    let is_module = words.windows(2).any(|pair| pair == ["mod", name]);
    is_module || listed(&file.code).any(|entry| entry.split("::").next() == Some(name))
}

#[cfg(test)]
mod tests {
    use super::super::project::{Crate, Project};
    use super::check;

    fn lost(files: &[(&str, &str)]) -> Vec<String> {
        let one = Crate {
            name: "a".into(),
            folder: "crates/a".into(),
            roots: vec!["crates/a/src/lib.rs".into()],
            test_roots: vec!["crates/a/tests/it/main.rs".into()],
            ..Crate::default()
        };
        let project = Project::in_memory(files).with_crates(vec![one]);
        check(&project).iter().map(|finding| finding.message("lost-file")).collect()
    }

    #[test]
    fn files_of_modules_and_of_lists_are_found() {
        let files = [
            ("crates/a/src/lib.rs", "mod roofs;\nmod walls;\n"),
            ("crates/a/src/walls.rs", "mod brick;\n"),
            ("crates/a/src/walls/brick.rs", "//! Brick.\n"),
            ("crates/a/src/roofs/mod.rs", "//! R.\nroofs! {\n    red::R,\n}\n"),
            ("crates/a/src/roofs/red.rs", "//! Red.\n"),
            ("crates/a/tests/it/main.rs", "mod doors;\n"),
            ("crates/a/tests/it/doors.rs", "//! Doors.\n"),
        ];
        assert_eq!(lost(&files), Vec::<String>::new());
    }

    #[test]
    fn a_file_that_no_module_declares_is_lost() {
        let files = [
            ("crates/a/src/lib.rs", "mod walls;\n"),
            ("crates/a/src/walls.rs", "//! Not brick.\n"),
            ("crates/a/src/walls/brick.rs", "//! Brick.\n"),
        ];
        assert_eq!(
            lost(&files),
            ["crates/a/src/walls/brick.rs:1: lost-file: no module declares it, so that nothing \
              of it is compiled; declare it with `mod`, or remove it"]
        );
    }
}
