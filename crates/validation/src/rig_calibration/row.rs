//! A number of the simulated rig beside the real one.

use std::fmt::Write as _;

/// How far apart the two may be, as a factor.
pub(super) const ALLOWED: f64 = 1.25;

/// A number, simulated and real.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Row {
    pub(super) name: String,
    pub(super) simulated: f64,
    /// None where nothing is known.
    pub(super) real: Option<f64>,
}

impl Row {
    pub(super) fn new(name: impl Into<String>, simulated: f64, real: Option<f64>) -> Self {
        Self { name: name.into(), simulated, real }
    }

    fn ratio(&self) -> Option<f64> {
        self.real.map(|real| self.simulated / real)
    }

    /// Whether both are alike, where both are known.
    pub(super) fn is_within(&self) -> Option<bool> {
        self.ratio().map(|ratio| (1.0 / ALLOWED..=ALLOWED).contains(&ratio))
    }
}

/// The rows as a table for people.
pub(super) fn text(rows: &[Row]) -> String {
    let mut text =
        String::from("| | real | simulated | ratio | within 1.25 × |\n|---|---|---|---|---|\n");
    for row in rows {
        let number = |value: f64| format!("{value:.4}");
        let real = row.real.map_or("–".to_owned(), number);
        let ratio = row.ratio().map_or("–".to_owned(), |ratio| format!("{ratio:.2}"));
        let within = match row.is_within() {
            Some(true) => "yes",
            Some(false) => "**no**",
            None => "–",
        };
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "| {} | {real} | {} | {ratio} | {within} |",
            row.name,
            number(row.simulated)
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::{Row, text};

    #[test]
    fn a_factor_to_either_side_is_within() {
        let within = |simulated: f64| Row::new("x", simulated, Some(2.0)).is_within();
        assert_eq!(
            [2.5, 2.51, 1.6, 1.59, f64::NAN].map(within),
            [Some(true), Some(false), Some(true), Some(false), Some(false)]
        );
        assert_eq!(Row::new("x", 1.0, None).is_within(), None);
        let text = text(&[Row::new("x", 3.0, Some(2.0)), Row::new("y", 1.0, None)]);
        assert!(text.contains("| x | 2.0000 | 3.0000 | 1.50 | **no** |"), "{text}");
        assert!(text.ends_with("| y | – | 1.0000 | – | – |\n"), "{text}");
    }
}
