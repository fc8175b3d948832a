//! Histograms as probability densities.

use super::{Extent, LegendKey, Mark, Swatch, described};
use crate::canvas::Canvas;
use crate::color::Color;
use crate::error::{ReportError, check_finite, check_positive, check_some};
use crate::scene::{Ink, Stroke};

/// The density of samples over equal bins: the bars' areas add up to 1 when all samples lie
/// within the bins, and to the share of samples that do otherwise.
#[derive(Debug, Clone)]
pub struct Histogram {
    samples: Vec<f64>,
    bins: usize,
    range: Option<(f64, f64)>,
    ink: Ink,
    label: Option<String>,
}

impl Histogram {
    /// Blue bars of opacity 0.35 over the whole range of the samples.
    pub fn new(samples: &[f64], bins: usize) -> Self {
        let samples = samples.to_vec();
        Self { samples, bins, range: None, ink: Ink::new(Color::BLUE, 0.35), label: None }
    }

    /// Spreads the bins from `low` to `high`, so that two histograms can be compared.
    #[must_use]
    pub fn range(mut self, low: f64, high: f64) -> Self {
        self.range = Some((low, high));
        self
    }

    /// The bins' edges, and the density in each, per unit of the samples.
    pub fn densities(&self) -> (Vec<f64>, Vec<f64>) {
        let (low, high) = self.range.unwrap_or_else(|| {
            let ends = |(a, b): (f64, f64), v: &f64| (a.min(*v), b.max(*v));
            let (low, high) = self.samples.iter().fold((f64::INFINITY, f64::NEG_INFINITY), ends);
            if low < high { (low, high) } else { (low - 0.5, high + 0.5) }
        });
        let width = (high - low) / self.bins as f64;
        let mut counts = vec![0usize; self.bins];
        for sample in self.samples.iter().filter(|v| (low..=high).contains(*v)) {
            // The upper end belongs to the last bin.
            let bin = ((sample - low) / width) as usize;
            counts[bin.min(self.bins - 1)] += 1;
        }
        let unit = 1.0 / (self.samples.len() as f64 * width);
        let edges = (0..=self.bins).map(|i| low + width * i as f64).collect();
        (edges, counts.into_iter().map(|count| count as f64 * unit).collect())
    }

    fn bars(&self) -> Vec<Vec<[f64; 2]>> {
        let (edges, densities) = self.densities();
        let bar = |(ends, height): (&[f64], &f64)| {
            vec![[ends[0], 0.0], [ends[0], *height], [ends[1], *height], [ends[1], 0.0]]
        };
        edges.windows(2).zip(&densities).filter(|(_, h)| **h > 0.0).map(bar).collect()
    }

    fn stroke(&self) -> Stroke {
        Stroke::new(self.ink.color, 1.0)
    }
}

builders!(Histogram: ink, label);

impl Mark for Histogram {
    fn name(&self) -> String {
        described("histogram", self.label.as_ref())
    }

    fn check(&self) -> Result<(), ReportError> {
        let name = self.name();
        check_some(&name, self.samples.len())?;
        check_finite(&name, "samples", &self.samples)?;
        check_positive(&name, "bins", self.bins as f64)?;
        check_positive(&name, "opacity", self.ink.opacity)?;
        self.range.map_or(Ok(()), |(low, high)| check_positive(&name, "range width", high - low))
    }

    fn extent(&self) -> Extent {
        let (edges, densities) = self.densities();
        let top = densities.iter().copied().fold(0.0, f64::max);
        let x = Some((edges[0], edges[self.bins]));
        Extent { x, y: Some((0.0, top)), pad: [true, true, false, true] }
    }

    fn draw(&self, canvas: &mut Canvas<'_>) {
        canvas.area(&self.bars(), Some(self.ink), Some(self.stroke()));
    }

    fn legend(&self) -> Option<LegendKey> {
        LegendKey::new(self.label.as_ref(), Swatch::Area(Some(self.ink), Some(self.stroke())))
    }

    fn needs_linear_axes(&self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use super::Histogram;

    #[test]
    fn bars_cover_an_area_of_one_and_the_upper_end_counts() {
        let (edges, densities) = Histogram::new(&[0.0, 1.0, 1.5, 4.0], 4).densities();
        assert_eq!(edges, [0.0, 1.0, 2.0, 3.0, 4.0]);
        assert_eq!(densities, [0.25, 0.5, 0.0, 0.25]);
    }

    #[test]
    fn samples_outside_the_bins_are_missing_from_the_area() {
        let (_, densities) = Histogram::new(&[0.5, 9.0], 2).range(0.0, 1.0).densities();
        assert_eq!(densities, [0.0, 1.0]);
    }
}
