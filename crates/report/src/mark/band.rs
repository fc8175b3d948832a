//! A shaded band between two lines.

use super::{Extent, LegendKey, Mark, Swatch, described};
use crate::canvas::Canvas;
use crate::color::Color;
use crate::error::{ReportError, check_finite, check_length, check_positive, check_some};
use crate::scene::Ink;

/// The area from `low[i]` to `high[i]` over `x[i]`, e.g. mean ± two standard deviations.
#[derive(Debug, Clone)]
pub struct Band {
    x: Vec<f64>,
    low: Vec<f64>,
    high: Vec<f64>,
    color: Color,
    opacity: f64,
    label: Option<String>,
}

impl Band {
    /// A blue band of opacity 0.2.
    pub fn new(x: &[f64], low: &[f64], high: &[f64]) -> Self {
        let (x, low, high) = (x.to_vec(), low.to_vec(), high.to_vec());
        Self { x, low, high, color: Color::BLUE, opacity: 0.2, label: None }
    }

    fn outline(&self) -> Vec<[f64; 2]> {
        let there = self.x.iter().zip(&self.low);
        let back = self.x.iter().zip(&self.high).rev();
        there.chain(back).map(|(x, y)| [*x, *y]).collect()
    }
}

builders!(Band: color, opacity, label);

impl Mark for Band {
    fn name(&self) -> String {
        described("band", self.label.as_ref())
    }

    fn check(&self) -> Result<(), ReportError> {
        let name = self.name();
        check_some(&name, self.x.len())?;
        check_length(&name, "low", self.x.len(), self.low.len())?;
        check_length(&name, "high", self.x.len(), self.high.len())?;
        check_finite(&name, "x", &self.x)?;
        check_finite(&name, "low", &self.low)?;
        check_finite(&name, "high", &self.high)?;
        check_positive(&name, "opacity", self.opacity)
    }

    fn extent(&self) -> Extent {
        Extent::of(self.outline())
    }

    fn draw(&self, canvas: &mut Canvas<'_>) {
        let ink = Ink::new(self.color, self.opacity);
        canvas.area(&[self.outline()], Some(ink), None);
    }

    fn legend(&self) -> Option<LegendKey> {
        let ink = Ink::new(self.color, self.opacity);
        LegendKey::new(self.label.as_ref(), Swatch::Area(Some(ink), None))
    }
}
