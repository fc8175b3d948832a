//! Unsafe code is forbidden, but for one named place.

use super::Rule;
use super::project::{Crate, Finding, Project};

pub(super) const RULE: Rule = Rule {
    name: "unsafe-code",
    demand: "unsafe code is forbidden, and denied with at most one exception in `dataset`",
    check,
};

/// The crate that maps logs into memory.
const EXCEPTED: &str = "dataset";

fn check(project: &Project) -> Vec<Finding> {
    let roots = project.crates().iter().flat_map(|member| check_roots(project, member));
    roots.chain(second_exceptions(project)).collect()
}

fn check_roots(project: &Project, member: &Crate) -> Vec<Finding> {
    let forbid = "#![forbid(unsafe_code)]";
    let deny = "#![deny(unsafe_code)]";
    let is_safe = |path: &String| {
        let text = project.text(path).unwrap_or_default();
        let has = |attribute| text.lines().any(|line| line == attribute);
        has(forbid) || (member.name == EXCEPTED && has(deny))
    };
    let open = member.roots.iter().filter(|path| !is_safe(path));
    let remedy = format!("add `{forbid}`");
    open.map(|path| Finding::new(path, 1, "unsafe code is not forbidden", &remedy)).collect()
}

fn second_exceptions(project: &Project) -> Vec<Finding> {
    let dataset = project.rust_files().iter().filter(|file| file.crate_name() == EXCEPTED);
    let exceptions = dataset.flat_map(|file| {
        let lines = file.code.lines().enumerate();
        let allowed = lines.filter(|(_, line)| {
            line.contains("allow(unsafe_code") || line.contains("expect(unsafe_code")
        });
        allowed.map(|(index, _)| (file.path.as_str(), index + 1))
    });
    let remedy = "go through the one that exists";
    let finding = |(path, line)| Finding::new(path, line, "a second exception", remedy);
    exceptions.skip(1).map(finding).collect()
}

#[cfg(test)]
mod tests {
    use super::super::project::{Crate, Finding, Project};
    use super::check;

    fn findings(name: &str, root: &str) -> Vec<Finding> {
        let path = format!("crates/{name}/src/lib.rs");
        let member = Crate { name: name.into(), roots: vec![path.clone()], ..Crate::default() };
        check(&Project::in_memory(&[(&path, root)]).with_crates(vec![member]))
    }

    #[test]
    fn a_root_that_allows_unsafe_code_is_found() {
        assert_eq!(findings("planar", "#![forbid(unsafe_code)]\n"), []);
        assert_eq!(findings("dataset", "#![deny(unsafe_code)]\n"), []);
        assert_eq!(
            findings("planar", "#![deny(unsafe_code)]\n")[0].message("r"),
            "crates/planar/src/lib.rs:1: r: unsafe code is not forbidden; \
             add `#![forbid(unsafe_code)]`"
        );
    }

    #[test]
    fn one_exception_is_fine_and_the_second_is_found() {
        let exception = "#[allow(unsafe_code)]\nfn f() {}\n";
        let project = |text: &str| Project::in_memory(&[("crates/dataset/src/a.rs", text)]);
        assert_eq!(check(&project(exception)), []);
        assert_eq!(check(&project(&exception.repeat(2))).len(), 1);
    }
}
