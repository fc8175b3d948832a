//! A library's root file is its table of contents.

use super::Rule;
use super::project::{Finding, Project, RustFile};

pub(super) const RULE: Rule = Rule {
    name: "library-root",
    demand: "lib.rs has attributes, `mod` and `pub use` lines only",
    check,
};

fn check(project: &Project) -> Vec<Finding> {
    let roots = project.rust_files().iter().filter(|file| file.path.ends_with("/src/lib.rs"));
    roots.filter_map(first_foreign_item).collect()
}

fn first_foreign_item(file: &RustFile) -> Option<Finding> {
    let mut rest = file.code.trim_start();
    while !rest.is_empty() {
        let after = after_attribute(rest).or_else(|| after_listing(rest));
        let Some(after) = after else {
            let line = file.code[..file.code.len() - rest.len()].matches('\n').count() + 1;
            let remedy = "move it to a module and list that";
            return Some(Finding::new(&file.path, line, "code in the library's root", remedy));
        };
        rest = after.trim_start();
    }
    None
}

fn after_attribute(code: &str) -> Option<&str> {
    let inside = code.strip_prefix("#![").or_else(|| code.strip_prefix("#["))?;
    let mut depth = 1;
    let end = inside.find(|letter| {
        depth += i32::from(letter == '[') - i32::from(letter == ']');
        depth == 0
    })?;
    Some(&inside[end + 1..])
}

/// What follows a `mod` or `pub use` statement; none where another item or a module's body begins.
fn after_listing(code: &str) -> Option<&str> {
    let (statement, rest) = code.split_once(';')?;
    let is_module =
        ["mod ", "pub mod ", "pub(crate) mod "].iter().any(|m| statement.starts_with(m));
    let lists = statement.starts_with("pub use ") || (is_module && !statement.contains('{'));
    lists.then_some(rest)
}

#[cfg(test)]
mod tests {
    use super::super::project::Project;
    use super::check;

    #[test]
    fn attributes_modules_and_exports_are_fine() {
        let code = "#![doc = include_str!(\"../README.md\")]\n\n\
            mod a;\n#[cfg(feature = \"x[\")]\nmod b;\n\npub use a::{\n    A, B,\n};\npub use b::C;\n";
        assert_eq!(check(&Project::in_memory(&[("crates/a/src/lib.rs", code)])), []);
    }

    #[test]
    fn anything_else_is_found_where_it_stands() {
        for item in ["fn f() {}", "mod b { fn f() {} }", "use a::A;", "const A: f64 = 1.0;"] {
            let code = format!("//! A.\n\nmod a;\n{item}\npub use a::A;\n");
            let findings = check(&Project::in_memory(&[("crates/a/src/lib.rs", &code)]));
            assert_eq!(
                findings[0].message("r"),
                "crates/a/src/lib.rs:4: r: code in the library's root; \
                 move it to a module and list that",
                "{item}"
            );
        }
    }
}
