//! A figure that lives in a page: in its colors, with texts over its parts.

use std::fmt::Write;

use crate::error::ReportError;
use crate::figure::Figure;
use crate::html::escape;

/// A figure inside a page, without files of its own; it follows the page's light or dark colors,
/// and shows the texts of its [`Hover`](crate::Hover) marks.
#[derive(Debug, Clone)]
pub struct Drawing {
    name: String,
    svg: String,
    caption: String,
}

impl Drawing {
    /// Draws a figure; the caption says what one sees in it, also to those who cannot.
    ///
    /// # Errors
    /// As [`Figure::svg`].
    pub fn new(figure: &Figure, caption: &str) -> Result<Self, ReportError> {
        let (name, caption) = (figure.name().to_owned(), caption.to_owned());
        Ok(Self { name, svg: figure.svg()?, caption })
    }

    pub(crate) fn push(&self, out: &mut String) {
        let how = if self.svg.contains("class=\"spot\"") {
            " tabindex=\"0\" aria-roledescription=\"figure whose values the arrow keys read\""
        } else {
            ""
        };
        let label = format!("{}. {}", self.name, self.caption);
        let _ = write!(
            out,
            "<figure class=\"drawing\">\n<div class=\"live\" role=\"group\"{how} \
             aria-label=\"{}\">\n{}</div>\n<figcaption>{}</figcaption>\n</figure>\n",
            escape(&label),
            self.svg,
            escape(&self.caption)
        );
    }
}
