//! Public names are made of the field's words: the glossary lists those that are not.

use super::Rule;
use super::project::{Finding, Project, RustFile};

pub(super) const RULE: Rule = Rule {
    name: "private-words",
    demand: "public names have no word that docs/glossary.md lists as not used",
    check,
};

const PAGE: &str = "docs/glossary.md";
/// Head of the table of words.
const HEAD: &str = "| not | but |";
/// What may stand between `pub` and a name.
const BEFORE_NAMES: [&str; 9] =
    ["const", "async", "unsafe", "fn", "struct", "enum", "trait", "type", "static"];

fn check(project: &Project) -> Vec<Finding> {
    let words = words(project.text(PAGE).unwrap_or_default());
    // Without its table the rule would hold whatever the names are.
    if words.is_empty() && !project.crates().is_empty() {
        return vec![Finding::new(
            PAGE,
            1,
            "no word is listed as not used",
            "bring its table back",
        )];
    }
    project.rust_files().iter().flat_map(|file| check_file(file, &words)).collect()
}

/// What is not used, and what is used for it.
fn words(page: &str) -> Vec<(&str, &str)> {
    let table = page.lines().skip_while(|line| *line != HEAD).skip(2);
    let cells = table.map_while(|line| line.strip_prefix('|')?.strip_suffix('|')?.split_once('|'));
    cells.map(|(not, but)| (not.trim(), but.trim())).collect()
}

fn check_file(file: &RustFile, words: &[(&str, &str)]) -> Vec<Finding> {
    let all: Vec<_> = file.words().filter(|(_, word)| !word.is_empty()).collect();
    let names = all.iter().enumerate().filter(|(_, (_, word))| *word == "pub");
    let names = names.filter_map(|(at, (line, _))| {
        let name = all[at + 1..].iter().find(|(_, word)| !BEFORE_NAMES.contains(word))?;
        (name.0 == *line).then_some(*name)
    });
    let finding = |(line, name): (usize, &str)| {
        let snake = format!("_{}_", snake_case(name));
        let (not, but) = words.iter().find(|(not, _)| snake.contains(&format!("_{not}_")))?;
        let fault = format!("`{name}` has a word that only we use: `{not}`");
        Some(Finding::new(&file.path, line, fault, format!("say {but}")))
    };
    names.filter_map(finding).collect()
}

/// `LookAlike` as `look_alike`.
fn snake_case(name: &str) -> String {
    let mut words = String::new();
    for letter in name.chars() {
        if letter.is_uppercase() && words.ends_with(|last: char| last.is_lowercase()) {
            words.push('_');
        }
        words.extend(letter.to_lowercase());
    }
    words
}

#[cfg(test)]
mod tests {
    use super::super::project::{Crate, Project};
    use super::check;

    const PAGE: &str = "# Glossary\n\n| not | but |\n|---|---|\n| look_alike | confounder |\n\
        | told | reported |\n\nmore\n";

    fn messages(code: &str) -> Vec<String> {
        let files = [("docs/glossary.md", PAGE), ("crates/a/src/b.rs", code)];
        check(&Project::in_memory(&files)).iter().map(|found| found.message("r")).collect()
    }

    #[test]
    fn words_that_are_not_used_are_found_in_public_names() {
        assert_eq!(
            messages("pub struct LookAlike {\n    pub look_alike_ids: u8,\n}\n"),
            [
                "crates/a/src/b.rs:1: r: `LookAlike` has a word that only we use: `look_alike`; \
                 say confounder",
                "crates/a/src/b.rs:2: r: `look_alike_ids` has a word that only we use: \
                 `look_alike`; say confounder"
            ]
        );
        assert_eq!(messages("pub const fn what_is_told() {}\n").len(), 1);
        assert_eq!(messages("pub(crate) fn told() {}\n").len(), 0);
    }

    #[test]
    fn a_glossary_without_its_table_is_found() {
        let project = Project::in_memory(&[("docs/glossary.md", "# Glossary\n")]);
        assert_eq!(check(&project.with_crates(vec![Crate::default()])).len(), 1);
    }

    #[test]
    fn private_names_and_longer_words_are_free() {
        assert!(messages("fn told() {}\npub fn retold() {}\n/// told\npub fn a() {}\n").is_empty());
    }
}
