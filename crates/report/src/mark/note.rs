//! Text at a data point.

use super::{Extent, Mark};
use crate::canvas::Canvas;
use crate::color::Color;
use crate::error::{ReportError, check_finite, check_some};
use crate::scene::Anchor;

/// Text at a data point, on a white halo.
#[derive(Debug, Clone)]
pub struct Note {
    at: [f64; 2],
    text: String,
    offset: [f64; 2],
    anchor: Anchor,
    color: Color,
}

impl Note {
    /// Dark text that starts 6 px right of the point and 4 px below its height.
    pub fn new(at: [f64; 2], text: &str) -> Self {
        let (offset, anchor) = ([6.0, -4.0], Anchor::Start);
        Self { at, text: text.to_owned(), offset, anchor, color: Color::INK }
    }

    /// Moves the baseline's anchor by (right, up) px from the point.
    #[must_use]
    pub fn offset(mut self, right: f64, up: f64) -> Self {
        self.offset = [right, up];
        self
    }

    /// Which point of the text is placed.
    #[must_use]
    pub fn anchor(mut self, anchor: Anchor) -> Self {
        self.anchor = anchor;
        self
    }
}

builders!(Note: color);

impl Mark for Note {
    fn name(&self) -> String {
        format!("note `{}`", self.text)
    }

    fn check(&self) -> Result<(), ReportError> {
        check_some(&self.name(), self.text.len())?;
        check_finite(&self.name(), "at", &self.at)?;
        check_finite(&self.name(), "offset", &self.offset)
    }

    fn extent(&self) -> Extent {
        Extent::of([self.at])
    }

    fn draw(&self, canvas: &mut Canvas<'_>) {
        canvas.text(self.at, self.offset, self.anchor, &self.text, self.color);
    }
}
