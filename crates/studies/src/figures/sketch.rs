//! What a figure's function returns.

use report::{Claim, Data, Figure};

/// A figure ready to be written, with its numbers, its words and the claims it bears on.
pub(crate) struct Sketch {
    pub(crate) figure: Figure,
    pub(crate) data: Data,
    /// What one sees, for the page.
    pub(crate) caption: String,
    /// The picture in words, for those who cannot see it.
    pub(crate) alt: String,
    pub(crate) claims: Vec<Claim>,
}

impl Sketch {
    /// A sketch that bears on no claim.
    pub(crate) fn new(figure: Figure, data: impl Into<Data>, caption: &str, alt: &str) -> Self {
        let (caption, alt) = (with_minus_signs(caption), alt.to_owned());
        Self { figure, data: data.into(), caption, alt, claims: Vec::new() }
    }

    /// The same sketch with a claim that its numbers settle.
    pub(crate) fn claim(mut self, claim: Claim) -> Self {
        self.claims.push(claim);
        self
    }
}

/// The text with a minus sign in place of each hyphen that stands before a number.
fn with_minus_signs(text: &str) -> String {
    let mut before = ' ';
    let mut rest = text.chars().peekable();
    let mut out = String::with_capacity(text.len());
    while let Some(c) = rest.next() {
        let number = rest.peek().is_some_and(char::is_ascii_digit);
        let minus = c == '-' && number && matches!(before, ' ' | '(' | '[');
        out.push(if minus { '\u{2212}' } else { c });
        before = c;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::with_minus_signs;

    #[test]
    fn only_signs_of_numbers_become_minus_signs() {
        let text = "at (-3.9, -45) within 1e-9, counter-clockwise, 2-3";
        assert_eq!(
            with_minus_signs(text),
            "at (\u{2212}3.9, \u{2212}45) within 1e-9, counter-clockwise, 2-3"
        );
    }
}
