//! Arrows: single vectors and vector fields.

use super::{Extent, LegendKey, Mark, Swatch, described};
use crate::canvas::Canvas;
use crate::color::Color;
use crate::error::{ReportError, check_finite, check_length, check_positive, check_some};
use crate::scene::Stroke;

/// Arrows from `tails[i]` to `tails[i] + scale · vectors[i]`.
#[derive(Debug, Clone)]
pub struct Arrows {
    tails: Vec<[f64; 2]>,
    vectors: Vec<[f64; 2]>,
    scale: f64,
    stroke: Stroke,
    label: Option<String>,
}

impl Arrows {
    /// Dark arrows, 1.4 px wide, at a scale of 1.
    pub fn new(tails: &[[f64; 2]], vectors: &[[f64; 2]]) -> Self {
        Self {
            tails: tails.to_vec(),
            vectors: vectors.to_vec(),
            scale: 1.0,
            stroke: Stroke::new(Color::INK, 1.4),
            label: None,
        }
    }

    /// Axis units drawn for each unit of the vectors.
    #[must_use]
    pub fn scale(mut self, scale: f64) -> Self {
        self.scale = scale;
        self
    }

    fn ends(&self) -> impl Iterator<Item = [[f64; 2]; 2]> + '_ {
        let arrows = self.tails.iter().zip(&self.vectors);
        arrows.map(|(t, v)| [*t, [t[0] + self.scale * v[0], t[1] + self.scale * v[1]]])
    }
}

builders!(Arrows: stroke, label);

impl Mark for Arrows {
    fn name(&self) -> String {
        described("arrows", self.label.as_ref())
    }

    fn check(&self) -> Result<(), ReportError> {
        let name = self.name();
        check_some(&name, self.tails.len())?;
        check_length(&name, "vectors", self.tails.len(), self.vectors.len())?;
        check_finite(&name, "tails (x, y)", self.tails.as_flattened())?;
        check_finite(&name, "vectors (x, y)", self.vectors.as_flattened())?;
        check_positive(&name, "scale", self.scale)?;
        check_positive(&name, "width", self.stroke.width)
    }

    fn extent(&self) -> Extent {
        Extent::of(self.ends().flatten())
    }

    fn draw(&self, canvas: &mut Canvas<'_>) {
        for [tail, tip] in self.ends() {
            canvas.arrow(tail, tip, self.stroke);
        }
    }

    fn legend(&self) -> Option<LegendKey> {
        LegendKey::new(self.label.as_ref(), Swatch::Arrow(self.stroke))
    }
}
