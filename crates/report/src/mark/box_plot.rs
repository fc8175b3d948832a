//! Box plots of samples.

use super::{Extent, LegendKey, Mark, Swatch, described};
use crate::canvas::Canvas;
use crate::color::Color;
use crate::error::{ReportError, check_finite, check_positive, check_some};
use crate::scene::{Ink, Stroke};

/// A box at `x` over the quartiles of samples, a line at the median, whiskers over 5 to 95 %.
#[derive(Debug, Clone)]
pub struct BoxPlot {
    x: f64,
    samples: Vec<f64>,
    width: f64,
    color: Color,
    label: Option<String>,
}

impl BoxPlot {
    /// A blue box, `width` wide in units of the x axis.
    pub fn new(x: f64, samples: &[f64], width: f64) -> Self {
        Self { x, samples: samples.to_vec(), width, color: Color::BLUE, label: None }
    }

    /// The 5, 25, 50, 75 and 95 % quantiles, interpolated linearly between samples.
    pub fn quantiles(&self) -> [f64; 5] {
        let mut sorted = self.samples.clone();
        sorted.sort_by(f64::total_cmp);
        [0.05, 0.25, 0.5, 0.75, 0.95].map(|share| {
            let at = share * (sorted.len() - 1) as f64;
            let (below, above) = (sorted[at.floor() as usize], sorted[at.ceil() as usize]);
            below + at.fract() * (above - below)
        })
    }

    fn paint(&self) -> (Ink, Stroke) {
        (Ink::new(self.color, 0.3), Stroke::new(self.color, 1.4))
    }
}

builders!(BoxPlot: color, label);

impl Mark for BoxPlot {
    fn name(&self) -> String {
        described("box plot", self.label.as_ref())
    }

    fn check(&self) -> Result<(), ReportError> {
        let name = self.name();
        check_some(&name, self.samples.len())?;
        check_finite(&name, "x", &[self.x])?;
        check_finite(&name, "samples", &self.samples)?;
        check_positive(&name, "width", self.width)
    }

    fn extent(&self) -> Extent {
        let [low, .., high] = self.quantiles();
        Extent::of([[self.x - 0.5 * self.width, low], [self.x + 0.5 * self.width, high]])
    }

    fn draw(&self, canvas: &mut Canvas<'_>) {
        let (fill, stroke) = self.paint();
        let [low, first, median, third, high] = self.quantiles();
        let (left, right) = (self.x - 0.5 * self.width, self.x + 0.5 * self.width);
        canvas.segments(
            &[[[self.x, low], [self.x, first]], [[self.x, third], [self.x, high]]],
            stroke,
        );
        canvas.tick([self.x, low], 4.0, stroke);
        canvas.tick([self.x, high], 4.0, stroke);
        let corners = vec![[left, first], [right, first], [right, third], [left, third]];
        canvas.area(&[corners], Some(fill), Some(stroke));
        canvas.segments(&[[[left, median], [right, median]]], Stroke::new(self.color, 2.4));
    }

    fn legend(&self) -> Option<LegendKey> {
        let (fill, stroke) = self.paint();
        LegendKey::new(self.label.as_ref(), Swatch::Area(Some(fill), Some(stroke)))
    }
}

#[cfg(test)]
mod tests {
    use super::BoxPlot;

    #[test]
    fn quantiles_of_a_ramp_are_its_shares() {
        let samples: Vec<f64> = (0..=100).rev().map(f64::from).collect();
        assert_eq!(BoxPlot::new(0.0, &samples, 1.0).quantiles(), [5.0, 25.0, 50.0, 75.0, 95.0]);
        assert_eq!(BoxPlot::new(0.0, &[2.0], 1.0).quantiles(), [2.0; 5]);
    }
}
