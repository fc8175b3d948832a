//! Files stay short enough to be read in one go.

use super::Rule;
use super::project::{Finding, Project};

pub(super) const RULE: Rule = Rule {
    name: "size",
    demand: "Rust files have at most 400 lines without tests, ARCHITECTURE.md 120, README code 12",
    check,
};

const MAX_CODE_LINES: usize = 400;
const MAX_ARCHITECTURE_LINES: usize = 120;
const MAX_README_CODE_LINES: usize = 12;

/// Files that may be longer, each with the reason why it has no seam.
const EXCEPTIONS: &[(&str, &str)] =
    &[("crates/report/examples/gallery.rs", "one of every mark, in one program")];

fn check(project: &Project) -> Vec<Finding> {
    let is_counted = |path: &str| {
        !path.contains("/tests/") && !EXCEPTIONS.iter().any(|(exception, _)| *exception == path)
    };
    let sources = project.rust_files().iter().filter(|file| is_counted(&file.path));
    let lengths = sources.map(|file| {
        let n_lines = lines_without_tests(&file.code);
        (file.path.as_str(), n_lines, MAX_CODE_LINES, "lines without tests", "split it at a noun")
    });
    let documents = [
        ("ARCHITECTURE.md", n_lines as fn(&str) -> usize, MAX_ARCHITECTURE_LINES, "lines"),
        ("README.md", rust_block_lines, MAX_README_CODE_LINES, "lines of Rust"),
    ]
    .map(|(path, count, limit, unit)| {
        let n_lines = project.text(path).map_or(0, count);
        (path, n_lines, limit, unit, "keep what a newcomer needs first")
    });
    let too_long = lengths.chain(documents).filter(|(_, n_lines, limit, ..)| n_lines > limit);
    too_long
        .map(|(path, n_lines, limit, unit, remedy)| {
            Finding::new(path, limit + 1, format!("{n_lines} {unit}, limit {limit}"), remedy)
        })
        .collect()
}

fn n_lines(text: &str) -> usize {
    text.lines().count()
}

/// Lines before the test module, which is the last thing in a file.
pub(super) fn lines_without_tests(code: &str) -> usize {
    let lines: Vec<_> = code.lines().map(str::trim).collect();
    let begins_tests =
        |pair: &[&str]| pair[0] == "#[cfg(test)]" && pair[1].starts_with("mod tests");
    lines.windows(2).position(begins_tests).unwrap_or(lines.len())
}

fn rust_block_lines(text: &str) -> usize {
    let inside = |block: &str| block.split("\n```").next().map_or(0, n_lines);
    text.split("```rust\n").skip(1).map(inside).sum()
}

#[cfg(test)]
mod tests {
    use super::super::project::{Finding, Project};
    use super::check;

    fn findings(path: &str, text: &str) -> Vec<Finding> {
        check(&Project::in_memory(&[(path, text)]))
    }

    #[test]
    fn a_file_at_the_limit_is_fine_and_one_line_more_is_found() {
        assert_eq!(findings("crates/a/src/b.rs", &"f();\n".repeat(400)), []);
        assert_eq!(
            findings("crates/a/src/b.rs", &"f();\n".repeat(401))[0].message("r"),
            "crates/a/src/b.rs:401: r: 401 lines without tests, limit 400; split it at a noun"
        );
    }

    #[test]
    fn tests_do_not_count_but_other_test_only_code_does() {
        let tests = "#[cfg(test)]\nmod tests {\n".to_owned() + &"f();\n".repeat(500) + "}\n";
        assert_eq!(findings("crates/a/src/b.rs", &tests), []);
        assert_eq!(findings("crates/a/tests/laws.rs", &"f();\n".repeat(500)), []);
        let helper = "#[cfg(test)]\nfn f() {}\n".to_owned() + &"f();\n".repeat(500);
        assert_eq!(findings("crates/a/src/b.rs", &helper).len(), 1);
    }

    #[test]
    fn documents_stay_short() {
        assert_eq!(findings("ARCHITECTURE.md", &"a\n".repeat(120)), []);
        assert_eq!(findings("ARCHITECTURE.md", &"a\n".repeat(121)).len(), 1);
        let readme = |n_lines| format!("# A\n```rust\n{}```\ntext\n", "f();\n".repeat(n_lines));
        assert_eq!(findings("README.md", &readme(12)), []);
        assert_eq!(
            findings("README.md", &readme(13))[0].message("r"),
            "README.md:13: r: 13 lines of Rust, limit 12; keep what a newcomer needs first"
        );
    }
}
