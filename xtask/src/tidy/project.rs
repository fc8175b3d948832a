//! The project as the rules see it: files and crates, in memory.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::ErrorKind;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result};

use super::rust_code::mask;
use crate::cargo::{cargo, output, workspace_root};
use crate::packages::{Package, packages};

/// Crates that are useful alone: of these it is read what they pull in.
pub(super) const LIGHT: &[&str] = &["planar", "mechanics", "gp-core", "gp-rff", "gp-sparse"];

/// Files by path (relative to the workspace root, `/`-separated) and the workspace's crates.
pub(super) struct Project {
    /// Text of every file; none where it is not UTF-8.
    files: BTreeMap<String, Option<String>>,
    rust_files: Vec<RustFile>,
    crates: Vec<Crate>,
}

/// A Rust source: its text, and the same lines with strings and comments blanked.
pub(super) struct RustFile {
    pub(super) path: String,
    pub(super) text: String,
    pub(super) code: String,
}

/// What the rules need to know of a workspace member.
#[derive(Default)]
pub(super) struct Crate {
    pub(super) name: String,
    pub(super) folder: String,
    pub(super) is_library: bool,
    pub(super) has_doctests: bool,
    /// Root files of its library and programs.
    pub(super) roots: Vec<String>,
    /// Root files of its programs of integration tests.
    pub(super) test_roots: Vec<String>,
    /// Other members that it depends on, in any dependency table.
    pub(super) imports: Vec<String>,
    /// Keys that its manifest leaves unset.
    pub(super) unset_keys: Vec<&'static str>,
    /// Packages that a user of this crate alone compiles; filled for light crates only.
    pub(super) pulls_in: BTreeSet<String>,
}

/// A place and what is wrong there.
#[derive(Debug, PartialEq)]
pub(super) struct Finding {
    path: String,
    /// Counted from 1.
    line: usize,
    fault: String,
    remedy: String,
}

impl Finding {
    pub(super) fn new(
        path: &str,
        line: usize,
        fault: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Finding {
        Finding { path: path.into(), line, fault: fault.into(), remedy: remedy.into() }
    }

    pub(super) fn message(&self, rule: &str) -> String {
        format!("{}:{}: {rule}: {}; {}", self.path, self.line, self.fault, self.remedy)
    }
}

impl Project {
    /// The files that git tracks or would track, and the crates that cargo knows.
    pub(super) fn load() -> Result<Project> {
        let root = workspace_root();
        let list = output(
            Command::new("git")
                .args(["ls-files", "-z", "--cached", "--others", "--exclude-standard"])
                .current_dir(&root),
        )?;
        let mut files = BTreeMap::new();
        for path in list.split('\0').filter(|path| !path.is_empty()) {
            match fs::read(root.join(path)) {
                Ok(bytes) => drop(files.insert(path.into(), String::from_utf8(bytes).ok())),
                // Git still lists a file that was deleted but not yet committed.
                Err(error) if error.kind() == ErrorKind::NotFound => {}
                Err(error) => return Err(error).with_context(|| format!("cannot read {path}")),
            }
        }
        Ok(Project::new(files).with_crates(load_crates(&root)?))
    }

    fn new(files: BTreeMap<String, Option<String>>) -> Project {
        let rust_file = |(path, text): (&String, &Option<String>)| {
            let text = text.clone().filter(|_| path.ends_with(".rs"))?;
            Some(RustFile { path: path.clone(), code: mask(&text), text })
        };
        Project { rust_files: files.iter().filter_map(rust_file).collect(), files, crates: vec![] }
    }

    pub(super) fn with_crates(self, crates: Vec<Crate>) -> Project {
        Project { crates, ..self }
    }

    #[cfg(test)]
    pub(super) fn in_memory(files: &[(&str, &str)]) -> Project {
        Project::new(files.iter().map(|&(path, text)| (path.into(), Some(text.into()))).collect())
    }

    pub(super) fn n_files(&self) -> usize {
        self.files.len()
    }

    pub(super) fn paths(&self) -> impl Iterator<Item = &str> {
        self.files.keys().map(String::as_str)
    }

    /// Text of one file; none where there is no such file or it is not text.
    pub(super) fn text(&self, path: &str) -> Option<&str> {
        self.files.get(path)?.as_deref()
    }

    pub(super) fn texts(&self) -> impl Iterator<Item = (&str, &str)> {
        self.files.iter().filter_map(|(path, text)| Some((path.as_str(), text.as_deref()?)))
    }

    pub(super) fn rust_files(&self) -> &[RustFile] {
        &self.rust_files
    }

    pub(super) fn crates(&self) -> &[Crate] {
        &self.crates
    }
}

impl RustFile {
    /// Name of the folder that the crate lies in, which is the crate's name.
    pub(super) fn crate_name(&self) -> &str {
        let mut folders = self.path.split('/');
        match folders.next() {
            Some("crates") => folders.next().unwrap_or(""),
            first => first.unwrap_or(""),
        }
    }

    /// Identifiers and keywords of the code with their line, counted from 1.
    pub(super) fn words(&self) -> impl Iterator<Item = (usize, &str)> {
        let is_part = |letter: char| letter.is_alphanumeric() || letter == '_';
        let lines = self.code.lines().enumerate();
        lines
            .flat_map(move |(index, line)| {
                line.split(move |letter| !is_part(letter)).map(move |word| (index + 1, word))
            })
            .filter(|(_, word)| word.starts_with(|letter: char| !letter.is_ascii_digit()))
    }
}

impl Crate {
    pub(super) fn manifest(&self) -> String {
        format!("{}/Cargo.toml", self.folder)
    }
}

fn load_crates(root: &Path) -> Result<Vec<Crate>> {
    let members = packages()?;
    let names: BTreeSet<_> = members.iter().map(|package| short_name(package.name())).collect();
    let relative =
        |path: &Path| path.strip_prefix(root).unwrap_or(path).to_string_lossy().replace('\\', "/");
    let load = |package: &Package| {
        let name = short_name(package.name());
        let roots_of = |kinds: &[&str]| {
            let of_kind =
                package.targets().filter(|target| kinds.iter().any(|kind| target.is(kind)));
            of_kind.map(|target| relative(target.root())).collect()
        };
        let imports = package.dependencies().map(short_name);
        Ok(Crate {
            folder: package.manifest().parent().map(relative).unwrap_or_default(),
            is_library: package.targets().any(|target| target.is("lib")),
            has_doctests: package.targets().any(|target| target.has_doctests()),
            roots: roots_of(&["lib", "bin"]),
            test_roots: roots_of(&["test"]),
            imports: imports.filter(|import| names.contains(import)).collect(),
            unset_keys: unset_keys(package),
            pulls_in: if LIGHT.contains(&name.as_str()) {
                tree(package.name())?
            } else {
                BTreeSet::new()
            },
            name,
        })
    };
    members.iter().map(load).collect()
}

/// What the workspace calls a package: its name without the prefix that makes it unique in public.
fn short_name(package: &str) -> String {
    package.strip_prefix("pushlab-").unwrap_or(package).to_owned()
}

/// Of the keys that every manifest has, and those of published packages, the unset ones.
fn unset_keys(package: &Package) -> Vec<&'static str> {
    let of_all = ["description", "license", "rust-version", "authors"];
    let of_published = ["readme", "categories", "keywords"];
    let of_published = of_published.into_iter().filter(|_| package.is_published());
    let is_unset = |key: &&str| package.is_unset(&key.replace('-', "_"));
    of_all.into_iter().chain(of_published).filter(is_unset).collect()
}

/// Names of the packages that building one crate alone compiles, with its default features.
fn tree(name: &str) -> Result<BTreeSet<String>> {
    let list = output(&mut cargo(&[
        "tree",
        "--locked",
        "--package",
        name,
        "--edges",
        "normal,build",
        "--prefix",
        "none",
        "--format",
        "{p}",
    ]))?;
    Ok(list.lines().filter_map(|line| line.split(' ').next()).map(String::from).collect())
}
