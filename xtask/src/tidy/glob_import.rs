//! Imports name what they import.

use super::Rule;
use super::project::{Finding, Project, RustFile};

pub(super) const RULE: Rule =
    Rule { name: "glob-import", demand: "imports name what they import", check };

fn check(project: &Project) -> Vec<Finding> {
    project.rust_files().iter().flat_map(check_file).collect()
}

fn check_file(file: &RustFile) -> Vec<Finding> {
    let is_part = |letter: char| letter.is_alphanumeric() || letter == '_';
    let is_import = |at: usize| {
        let before = !file.code[..at].ends_with(is_part);
        // `use<'a>` lists what a return type captures.
        before && file.code[at + 3..].starts_with(char::is_whitespace)
    };
    let imports = file.code.match_indices("use").filter(|&(at, _)| is_import(at));
    let globs = imports.filter(|&(at, _)| {
        file.code[at..].split(';').next().is_some_and(|statement| statement.contains('*'))
    });
    let finding = |(at, _): (usize, &str)| {
        let line = file.code[..at].matches('\n').count() + 1;
        Finding::new(&file.path, line, "a glob import hides what is used", "name the items")
    };
    globs.map(finding).collect()
}

#[cfg(test)]
mod tests {
    use super::super::project::Project;
    use super::check;

    #[test]
    fn imports_by_name_are_fine() {
        for code in [
            "use planar::{Pose, Twist};\nlet a = b * c;\n",
            "fn f() -> impl Fn() + use<> { move || *x }\n",
            "// use planar::*;\n",
            "fn reuse (a: *const u8);\n",
        ] {
            assert_eq!(check(&Project::in_memory(&[("a.rs", code)])), [], "{code}");
        }
    }

    #[test]
    fn glob_imports_are_found_over_several_lines_and_in_tests() {
        for code in ["\nuse super::*;\n", "\npub use a::{\n    b::*,\n};\n", "\n    use a::{*};\n"]
        {
            let findings = check(&Project::in_memory(&[("a.rs", code)]));
            assert_eq!(
                findings[0].message("r"),
                "a.rs:2: r: a glob import hides what is used; name the items"
            );
        }
    }
}
