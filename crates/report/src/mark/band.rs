//! A shaded band between two lines.

use super::{Extent, LegendKey, Mark, Swatch, described};
use crate::canvas::Canvas;
use crate::color::Color;
use crate::error::{ReportError, check_columns, check_positive};
use crate::scene::Ink;

/// The area from `low[i]` to `high[i]` over `x[i]`, e.g. mean ± two standard deviations.
#[derive(Debug, Clone)]
pub struct Band {
    x: Vec<f64>,
    low: Vec<f64>,
    high: Vec<f64>,
    ink: Ink,
    label: Option<String>,
}

impl Band {
    /// A blue band of opacity 0.2.
    pub fn new(x: &[f64], low: &[f64], high: &[f64]) -> Self {
        let (x, low, high) = (x.to_vec(), low.to_vec(), high.to_vec());
        Self { x, low, high, ink: Ink::new(Color::BLUE, 0.2), label: None }
    }

    fn outline(&self) -> Vec<[f64; 2]> {
        let there = self.x.iter().zip(&self.low);
        let back = self.x.iter().zip(&self.high).rev();
        there.chain(back).map(|(x, y)| [*x, *y]).collect()
    }
}

builders!(Band: ink, label);

impl Mark for Band {
    fn name(&self) -> String {
        described("band", self.label.as_ref())
    }

    fn check(&self) -> Result<(), ReportError> {
        let name = self.name();
        check_columns(&name, &[("x", &self.x), ("low", &self.low), ("high", &self.high)])?;
        check_positive(&name, "opacity", self.ink.opacity)
    }

    fn extent(&self) -> Extent {
        Extent::of(self.outline())
    }

    fn draw(&self, canvas: &mut Canvas<'_>) {
        canvas.area(&[self.outline()], Some(self.ink), None);
    }

    fn legend(&self) -> Option<LegendKey> {
        LegendKey::new(self.label.as_ref(), Swatch::Area(Some(self.ink), None))
    }
}
