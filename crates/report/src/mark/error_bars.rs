//! Vertical error bars.

use super::{Extent, LegendKey, Mark, Swatch, described};
use crate::canvas::Canvas;
use crate::color::Color;
use crate::error::{ReportError, check_finite, check_length, check_positive, check_some};
use crate::scene::Stroke;

/// Vertical bars from `low[i]` to `high[i]` at `x[i]`, with caps.
#[derive(Debug, Clone)]
pub struct ErrorBars {
    x: Vec<f64>,
    low: Vec<f64>,
    high: Vec<f64>,
    color: Color,
    width: f64,
    label: Option<String>,
}

impl ErrorBars {
    /// Blue bars, 1.4 px wide.
    pub fn new(x: &[f64], low: &[f64], high: &[f64]) -> Self {
        let (x, low, high) = (x.to_vec(), low.to_vec(), high.to_vec());
        Self { x, low, high, color: Color::BLUE, width: 1.4, label: None }
    }
}

builders!(ErrorBars: color, width, label);

impl Mark for ErrorBars {
    fn name(&self) -> String {
        described("error bars", self.label.as_ref())
    }

    fn check(&self) -> Result<(), ReportError> {
        let name = self.name();
        check_some(&name, self.x.len())?;
        check_length(&name, "low", self.x.len(), self.low.len())?;
        check_length(&name, "high", self.x.len(), self.high.len())?;
        check_finite(&name, "x", &self.x)?;
        check_finite(&name, "low", &self.low)?;
        check_finite(&name, "high", &self.high)?;
        check_positive(&name, "width", self.width)
    }

    fn extent(&self) -> Extent {
        let ends = self.low.iter().zip(&self.high);
        Extent::of(self.x.iter().zip(ends).flat_map(|(x, (a, b))| [[*x, *a], [*x, *b]]))
    }

    fn draw(&self, canvas: &mut Canvas<'_>) {
        let stroke = Stroke::new(self.color, self.width);
        for ((x, low), high) in self.x.iter().zip(&self.low).zip(&self.high) {
            canvas.segments(&[[[*x, *low], [*x, *high]]], stroke);
            canvas.tick([*x, *low], 3.5, stroke);
            canvas.tick([*x, *high], 3.5, stroke);
        }
    }

    fn legend(&self) -> Option<LegendKey> {
        LegendKey::new(self.label.as_ref(), Swatch::Line(Stroke::new(self.color, self.width)))
    }
}
