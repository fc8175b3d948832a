//! Reference lines and shaded intervals across a panel.

use super::{Extent, LegendKey, Mark, Swatch, described};
use crate::canvas::Canvas;
use crate::color::Color;
use crate::error::{ReportError, check_finite, check_positive};
use crate::scene::{Ink, Stroke};

/// A line, or a shaded interval, across the whole panel.
#[derive(Debug, Clone)]
pub struct Guide {
    from: f64,
    to: f64,
    upright: bool,
    stroke: Stroke,
    label: Option<String>,
}

impl Guide {
    /// A thin gray line at a height of `y`.
    pub fn horizontal(y: f64) -> Self {
        Self::between(y, y, false)
    }

    /// A thin gray line at `x`.
    pub fn vertical(x: f64) -> Self {
        Self::between(x, x, true)
    }

    /// A shaded strip from `low` to `high` on the x axis, e.g. an interval of contact.
    pub fn interval(low: f64, high: f64) -> Self {
        Self::between(low, high, true)
    }

    fn between(from: f64, to: f64, upright: bool) -> Self {
        Self { from, to, upright, stroke: Stroke::new(Color::GRAY, 1.2), label: None }
    }

    fn ink(&self) -> Ink {
        Ink { opacity: 0.15, ..self.stroke.ink }
    }
}

builders!(Guide: stroke, dashed, label);

impl Mark for Guide {
    fn name(&self) -> String {
        described("guide", self.label.as_ref())
    }

    fn check(&self) -> Result<(), ReportError> {
        check_finite(&self.name(), "position", &[self.from, self.to])?;
        check_positive(&self.name(), "width", self.stroke.width)
    }

    fn extent(&self) -> Extent {
        let range = Some((self.from.min(self.to), self.from.max(self.to)));
        let (x, y) = if self.upright { (range, None) } else { (None, range) };
        Extent { x, y, pad: [true; 4] }
    }

    fn draw(&self, canvas: &mut Canvas<'_>) {
        let [(left, right), (bottom, top)] = canvas.ranges();
        if self.from != self.to {
            let (a, b) = (self.from, self.to);
            let strip = vec![[a, bottom], [b, bottom], [b, top], [a, top]];
            canvas.area(&[strip], Some(self.ink()), None);
        } else if self.upright {
            canvas.line([[self.from, bottom], [self.from, top]], self.stroke);
        } else {
            canvas.line([[left, self.from], [right, self.from]], self.stroke);
        }
    }

    fn legend(&self) -> Option<LegendKey> {
        let swatch = if self.from == self.to {
            Swatch::Line(self.stroke)
        } else {
            Swatch::Area(Some(self.ink()), None)
        };
        LegendKey::new(self.label.as_ref(), swatch)
    }
}
