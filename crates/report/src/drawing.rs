//! A figure that lives in a page: in its colors, with texts over its parts.

use std::fmt::Write;

use crate::data::Table;
use crate::error::ReportError;
use crate::figure::Figure;
use crate::html::escape;
use crate::region::CellsOf;

/// A figure inside a page, without files of its own; it follows the page's light or dark colors,
/// and shows the texts of its [`Hover`](crate::Hover) marks.
#[derive(Debug, Clone)]
pub struct Drawing {
    name: String,
    svg: String,
    caption: String,
    anchor: Option<String>,
    cells_of: Option<CellsOf>,
    csv: Option<String>,
    after: Option<Box<Drawing>>,
}

impl Drawing {
    /// Draws a figure; the caption says what one sees in it, also to those who cannot.
    ///
    /// # Errors
    /// As [`Figure::svg`].
    pub fn new(figure: &Figure, caption: &str) -> Result<Self, ReportError> {
        let (name, caption) = (figure.name().to_owned(), caption.to_owned());
        let (svg, anchor, cells_of, csv, after) = (figure.svg()?, None, None, None, None);
        Ok(Self { name, svg, caption, anchor, cells_of, csv, after })
    }

    /// Names it, so that links of the page can lead to it.
    #[must_use]
    pub fn anchor(mut self, anchor: &str) -> Self {
        self.anchor = Some(anchor.to_owned());
        self
    }

    /// Says what its cells are, so that a reader goes from each to its pushes in the
    /// [`Player`](crate::Player).
    #[must_use]
    pub fn cells_of(mut self, cells_of: CellsOf) -> Self {
        self.cells_of = Some(cells_of);
        self
    }

    /// Lets a reader save the numbers behind it.
    ///
    /// # Errors
    /// As [`Table::to_csv`].
    pub fn data(mut self, table: &Table) -> Result<Self, ReportError> {
        self.csv = Some(table.to_csv(&self.name)?);
        Ok(self)
    }

    /// Lays another drawing of the same size over this one, behind a slider; they stand side by side
    /// on paper and without scripts.
    #[must_use]
    pub fn before(mut self, after: Self) -> Self {
        self.after = Some(Box::new(after));
        self
    }

    pub(crate) fn anchors(&self) -> impl Iterator<Item = &str> {
        let after = self.after.as_ref().and_then(|after| after.anchor.as_deref());
        self.anchor.as_deref().into_iter().chain(after)
    }

    pub(crate) fn push(&self, out: &mut String) {
        match &self.after {
            None => self.push_alone(out),
            Some(after) => {
                out.push_str("<div class=\"pair\" data-pair>\n");
                self.push_alone(out);
                after.push_alone(out);
                out.push_str("</div>\n");
            }
        }
    }

    fn push_alone(&self, out: &mut String) {
        let how = if self.svg.contains("class=\"spot\"") {
            " tabindex=\"0\" aria-roledescription=\"figure whose values the arrow keys read\""
        } else {
            ""
        };
        let label = format!("{}. {}", self.name, self.caption);
        let id = self.anchor.as_ref().map_or_else(String::new, |name| format!(" id=\"{name}\""));
        let cells = self.cells_of.as_ref().map(CellsOf::attributes).unwrap_or_default();
        let _ = write!(
            out,
            "<figure class=\"drawing\">\n<div class=\"live\" role=\"group\"{how}{id}{cells} \
             aria-label=\"{}\">\n{}</div>\n<figcaption>{}</figcaption>\n",
            escape(&label),
            self.svg,
            escape(&self.caption)
        );
        if let Some(csv) = &self.csv {
            let _ = writeln!(out, "<pre hidden data-csv>{}</pre>", escape(csv));
        }
        out.push_str("</figure>\n");
    }
}
