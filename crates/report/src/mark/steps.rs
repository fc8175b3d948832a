//! A piecewise constant line.

use super::{Extent, LegendKey, Mark, Swatch, described};
use crate::canvas::Canvas;
use crate::color::Color;
use crate::error::{ReportError, check_finite, check_length, check_positive, check_some};
use crate::scene::Stroke;

/// A piecewise constant line: `values[i]` from `edges[i]` to `edges[i + 1]`.
#[derive(Debug, Clone)]
pub struct Steps {
    edges: Vec<f64>,
    values: Vec<f64>,
    stroke: Stroke,
    label: Option<String>,
}

impl Steps {
    /// A solid blue line, 1.8 px wide; there is one edge more than values.
    pub fn new(edges: &[f64], values: &[f64]) -> Self {
        let (edges, values) = (edges.to_vec(), values.to_vec());
        Self { edges, values, stroke: Stroke::new(Color::BLUE, 1.8), label: None }
    }

    fn corners(&self) -> impl Iterator<Item = [f64; 2]> + '_ {
        let treads = self.edges.windows(2).zip(&self.values);
        treads.flat_map(|(ends, value)| [[ends[0], *value], [ends[1], *value]])
    }
}

builders!(Steps: stroke, dashed, label);

impl Mark for Steps {
    fn name(&self) -> String {
        described("steps", self.label.as_ref())
    }

    fn check(&self) -> Result<(), ReportError> {
        let name = self.name();
        check_some(&name, self.values.len())?;
        check_length(&name, "edges", self.values.len() + 1, self.edges.len())?;
        check_finite(&name, "edges", &self.edges)?;
        check_finite(&name, "values", &self.values)?;
        check_positive(&name, "width", self.stroke.width)
    }

    fn extent(&self) -> Extent {
        Extent::of(self.corners())
    }

    fn draw(&self, canvas: &mut Canvas<'_>) {
        canvas.line(self.corners(), self.stroke);
    }

    fn legend(&self) -> Option<LegendKey> {
        LegendKey::new(self.label.as_ref(), Swatch::Line(self.stroke))
    }
}
