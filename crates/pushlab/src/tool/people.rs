//! Units and running text as people like to read them.

use std::borrow::Cow;

use effects::readable_unit;
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
    match unit {
        "" | "1" => String::new(),
        "°" => unit.to_owned(),
        unit => format!(" {unit}"),
    }
}

/// A number in four significant digits, without zeros that say nothing.
pub(crate) fn four_digits(value: f64) -> String {
    let rounded = format!("{value:.3e}");
    let number: f64 = rounded.parse().unwrap_or(value);
    match number.abs() {
        // The shortest text that is the rounded number.
        1e-4..1e6 => number.to_string(),
        0.0 => "0".to_owned(),
        _ => format!("{number:e}"),
    }
}

/// Digits behind the point with which a standard error, and what it is of, has two.
pub(crate) fn digits_of_error(se: f64) -> usize {
    if se > 0.0 { (1.0 - se.log10().floor()).clamp(0.0, 12.0) as usize } else { 0 }
}

/// A text with the first twelve of the digits of each SHA-256 in it.
pub(crate) fn short_digests(text: &str) -> String {
    const DIGITS: usize = 64;
    const SHOWN: usize = 12;
    let mut short = String::with_capacity(text.len());
    let mut word = String::new();
    for letter in text.chars().map(Some).chain([None]) {
        match letter {
            Some(letter) if letter.is_ascii_alphanumeric() => word.push(letter),
            other => {
                let is_digest =
                    word.len() == DIGITS && word.chars().all(|digit| digit.is_ascii_hexdigit());
                short += if is_digest { &word[..SHOWN] } else { &word };
                short.extend(is_digest.then_some('…'));
                short.extend(other);
                word.clear();
            }
        }
    }
    short
}

/// Two significant digits, and all before the point.
pub(crate) fn two_digits(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let digits = (1 - value.abs().log10().floor() as i32).max(0) as usize;
    format!("{value:.digits$}")
}

/// A standard deviation with its interval, as "0.30 mm (0.19 to 0.48)".
pub(crate) fn spread(sd_and_ends: [f64; 3], unit: &str) -> String {
    let (per, unit) = readable_unit(unit);
    let [sd, low, high] = sd_and_ends.map(|sd| two_digits(per * sd));
    format!("{sd}{} ({low} to {high})", behind_number(unit))
}

#[cfg(test)]
mod tests {
    use super::{four_digits, lines, short_digests, spread, two_digits};

    #[test]
    fn numbers_have_two_digits() {
        for (value, text) in [(0.001_234, "0.0012"), (0.99, "0.99"), (12.34, "12"), (1.06, "1.1")] {
            assert_eq!(two_digits(value), text);
        }
        assert_eq!(spread([3e-4, 1.9e-4, 4.8e-4], "m"), "0.30 mm (0.19 to 0.48)");
    }

    #[test]
    fn numbers_have_four_digits_and_digests_twelve() {
        for (value, text) in [
            (0.594235601750097, "0.5942"),
            (1.0, "1"),
            (0.0, "0"),
            (-1234.56, "-1235"),
            (123456.0, "123500"),
            (2.34567e-5, "2.346e-5"),
            (9.99999e-5, "0.0001"),
            (1e6, "1e6"),
            (0.25, "0.25"),
        ] {
            assert_eq!(four_digits(value), text);
        }
        let digest = "0123456789abcdef".repeat(4);
        assert_eq!(
            short_digests(&format!("a (sha256:{digest}, by b) {digest}")),
            "a (sha256:0123456789ab…, by b) 0123456789ab…"
        );
        let others = format!("{digest}0 g{} ü", &digest[1..]);
        assert_eq!(short_digests(&others), others);
    }

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
