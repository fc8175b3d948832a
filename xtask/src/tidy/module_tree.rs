//! The modules of a crate and who imports whom, read from the sources.

use std::collections::{BTreeMap, BTreeSet};

use super::project::{Project, RustFile};
use super::use_path::{exports, globs, items, paths};

/// The modules of one crate, without its tests.
pub(super) struct ModuleTree<'a> {
    /// The file of each module by its path, as `limit_surface::patch`; the root's is empty.
    files: BTreeMap<String, &'a RustFile>,
    /// Names that modules hand on, and where they come from.
    handed_on: BTreeMap<String, String>,
}

/// An import of one module by another: the line on which it is named first.
pub(super) type Imports = BTreeMap<String, BTreeMap<String, usize>>;

impl<'a> ModuleTree<'a> {
    /// The modules below the folder of `root`, such as `crates/planar/src/lib.rs`.
    pub(super) fn of(project: &'a Project, root: &'a str) -> Self {
        let folder = root.rsplit_once('/').map_or("", |(folder, _)| folder);
        let below = |file: &&RustFile| file.path.starts_with(&format!("{folder}/"));
        let files = project.rust_files().iter().filter(below);
        let mut files: BTreeMap<String, &RustFile> = files
            .filter_map(|file| Some((module(file.path.strip_prefix(folder)?, root, file)?, file)))
            .collect();
        for test in files.values().flat_map(|file| test_modules(code(file))).collect::<Vec<_>>() {
            files.retain(|module, _| !module.split("::").any(|part| part == test));
        }
        let mut handed_on = BTreeMap::new();
        for (module, file) in &files {
            for (name, from) in exports(code(file), module) {
                handed_on.insert(joined(module, &name), from);
            }
        }
        for (module, file) in &files {
            for other in globs(code(file), module) {
                let below = format!("{other}::");
                let own = files.get(&other).into_iter().flat_map(|file| items(code(file)));
                let handed = handed_on.keys().filter_map(|name| name.strip_prefix(&below));
                let handed = handed.filter(|name| !name.contains("::"));
                let names: Vec<String> = own.chain(handed).map(str::to_owned).collect();
                for name in names {
                    handed_on.insert(joined(module, &name), below.clone() + &name);
                }
            }
        }
        Self { files, handed_on }
    }

    /// The file of a module.
    pub(super) fn file(&self, module: &str) -> &'a RustFile {
        self.files[module]
    }

    /// Who imports whom. A folder's own file is its face: what it takes from its own modules is
    /// left out, and so is the root.
    pub(super) fn imports(&self) -> Imports {
        let of = |(module, file): (&String, &&RustFile)| {
            let mut imports = BTreeMap::new();
            for (line, path) in paths(code(file), module) {
                let Some(other) = self.resolved(path) else { continue };
                if other != *module && !other.starts_with(&format!("{module}::")) {
                    imports.entry(other).or_insert(line);
                }
            }
            (module.clone(), imports)
        };
        self.files.iter().filter(|(module, _)| !module.is_empty()).map(of).collect()
    }

    /// The module that a path leads to, through what others hand on.
    fn resolved(&self, mut path: String) -> Option<String> {
        let mut seen = BTreeSet::new();
        while let Some(from) = self.handed_on.get(&path) {
            if !seen.insert(path.clone()) {
                break;
            }
            path.clone_from(from);
        }
        loop {
            if self.files.contains_key(&path) {
                return (!path.is_empty()).then_some(path);
            }
            path.truncate(path.rfind("::")?);
        }
    }
}

/// A name in a module.
fn joined(module: &str, name: &str) -> String {
    if module.is_empty() { name.to_owned() } else { format!("{module}::{name}") }
}

/// The module of a file below `src`; none for other roots and their programs.
fn module(below: &str, root: &str, file: &RustFile) -> Option<String> {
    if file.path == root {
        return Some(String::new());
    }
    let path = below.trim_start_matches('/').strip_suffix(".rs")?;
    let path = path.strip_suffix("/mod").unwrap_or(path);
    (path != "lib" && path != "main" && !path.starts_with("bin/")).then(|| path.replace('/', "::"))
}

/// Modules that are there for tests alone.
fn test_modules(code: &str) -> Vec<&str> {
    let declared = code.split("#[cfg(test)]").skip(1);
    declared
        .filter_map(|rest| rest.trim_start().strip_prefix("mod ")?.split_once(';'))
        .map(|(name, _)| name.trim())
        .chain(["tests"])
        .collect()
}

/// The code of a file before its tests.
fn code(file: &RustFile) -> &str {
    let tests = file.code.match_indices("#[cfg(test)]").find(|(at, mark)| {
        let rest = file.code[at + mark.len()..].trim_start();
        rest.starts_with("mod ") && rest.find('{') < rest.find(';')
    });
    tests.map_or(file.code.as_str(), |(at, _)| &file.code[..at])
}
