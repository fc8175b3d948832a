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
        let (caption, alt) = (caption.to_owned(), alt.to_owned());
        Self { figure, data: data.into(), caption, alt, claims: Vec::new() }
    }

    /// The same sketch with a claim that its numbers settle.
    pub(crate) fn claim(mut self, claim: Claim) -> Self {
        self.claims.push(claim);
        self
    }
}
