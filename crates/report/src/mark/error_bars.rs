//! Vertical error bars.

use super::{Extent, LegendKey, Mark, Swatch, described};
use crate::canvas::Canvas;
use crate::color::Color;
use crate::error::{ReportError, check_columns, check_positive};
use crate::scene::Stroke;

/// Vertical bars from `low[i]` to `high[i]` at `x[i]`, with caps.
#[derive(Debug, Clone)]
pub struct ErrorBars {
    x: Vec<f64>,
    low: Vec<f64>,
    high: Vec<f64>,
    stroke: Stroke,
    label: Option<String>,
}

impl ErrorBars {
    /// Blue bars, 1.4 px wide.
    pub fn new(x: &[f64], low: &[f64], high: &[f64]) -> Self {
        let (x, low, high) = (x.to_vec(), low.to_vec(), high.to_vec());
        Self { x, low, high, stroke: Stroke::new(Color::BLUE, 1.4), label: None }
    }
}

builders!(ErrorBars: stroke, label);

impl Mark for ErrorBars {
    fn name(&self) -> String {
        described("error bars", self.label.as_ref())
    }

    fn check(&self) -> Result<(), ReportError> {
        let name = self.name();
        check_columns(&name, &[("x", &self.x), ("low", &self.low), ("high", &self.high)])?;
        check_positive(&name, "width", self.stroke.width)
    }

    fn extent(&self) -> Extent {
        let ends = self.low.iter().zip(&self.high);
        Extent::of(self.x.iter().zip(ends).flat_map(|(x, (a, b))| [[*x, *a], [*x, *b]]))
    }

    fn draw(&self, canvas: &mut Canvas<'_>) {
        for ((x, low), high) in self.x.iter().zip(&self.low).zip(&self.high) {
            canvas.segments(&[[[*x, *low], [*x, *high]]], self.stroke);
            canvas.tick([*x, *low], 3.5, self.stroke);
            canvas.tick([*x, *high], 3.5, self.stroke);
        }
    }

    fn legend(&self) -> Option<LegendKey> {
        LegendKey::new(self.label.as_ref(), Swatch::Line(self.stroke))
    }
}
