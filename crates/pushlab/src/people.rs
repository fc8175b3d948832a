//! Units and running text as people like to read them.

use std::borrow::Cow;

use textwrap::{Options, WordSplitter, WrapAlgorithm};

/// The words of a text on lines of at most so many columns; those with hyphens stay whole.
pub(crate) fn lines(text: &str, columns: usize) -> Vec<Cow<'_, str>> {
    let options = Options::new(columns)
        .word_splitter(WordSplitter::NoHyphenation)
        .wrap_algorithm(WrapAlgorithm::FirstFit)
        .break_words(false);
    textwrap::wrap(text, options)
}

/// What stands behind a number in a unit: nothing if it has none.
pub(crate) fn behind_number(unit: &str) -> String {
    if unit == "1" { String::new() } else { format!(" {unit}") }
}

/// A number of SI units per unit for people, and that unit.
pub(crate) fn people(unit: &str) -> (f64, &str) {
    match unit {
        "m" => (1e3, "mm"),
        "rad" => (1.0_f64.to_degrees(), "°"),
        "s" => (1e3, "ms"),
        "m/N" => (1e6, "µm/N"),
        "1" => (1.0, ""),
        other => (1.0, other),
    }
}

#[cfg(test)]
mod tests {
    use super::lines;

    #[test]
    fn lines_are_as_long_as_words_allow() {
        let text = "seven ".repeat(30);
        let found = lines(&text, 80);
        assert_eq!(found.len(), 3);
        assert!(found.iter().all(|line| line.len() <= 80));
        assert_eq!(found.join(" "), text.trim_end());
        assert_eq!(lines("a limit-surface", 10), ["a", "limit-surface"]);
    }
}
