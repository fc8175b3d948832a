//! A line through points.

use super::{Extent, LegendKey, Mark, Swatch, described, pairs};
use crate::canvas::Canvas;
use crate::color::Color;
use crate::error::{ReportError, check_columns, check_positive};
use crate::scene::Stroke;

/// A line through the points `(x[i], y[i])` in their order.
#[derive(Debug, Clone)]
pub struct Line {
    x: Vec<f64>,
    y: Vec<f64>,
    stroke: Stroke,
    label: Option<String>,
}

impl Line {
    /// A solid blue line, 1.8 px wide.
    pub fn new(x: &[f64], y: &[f64]) -> Self {
        let (x, y) = (x.to_vec(), y.to_vec());
        Self { x, y, stroke: Stroke::new(Color::BLUE, 1.8), label: None }
    }

    /// The same through points given as pairs.
    pub fn through(points: &[[f64; 2]]) -> Self {
        let (x, y): (Vec<_>, Vec<_>) = points.iter().map(|[x, y]| (*x, *y)).unzip();
        Self::new(&x, &y)
    }
}

builders!(Line: stroke, dashed, label);

impl Mark for Line {
    fn name(&self) -> String {
        described("line", self.label.as_ref())
    }

    fn check(&self) -> Result<(), ReportError> {
        let name = self.name();
        check_columns(&name, &[("x", &self.x), ("y", &self.y)])?;
        check_positive(&name, "width", self.stroke.width)
    }

    fn extent(&self) -> Extent {
        Extent::of(pairs(&self.x, &self.y))
    }

    fn draw(&self, canvas: &mut Canvas<'_>) {
        canvas.line(pairs(&self.x, &self.y), self.stroke);
    }

    fn legend(&self) -> Option<LegendKey> {
        LegendKey::new(self.label.as_ref(), Swatch::Line(self.stroke))
    }
}
