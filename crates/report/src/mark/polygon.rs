//! A closed polygon, outlined and filled.

use super::{Extent, LegendKey, Mark, Swatch, described};
use crate::canvas::Canvas;
use crate::color::Color;
use crate::error::{ReportError, check_finite, check_positive, check_some};
use crate::scene::{Ink, Stroke};

/// A closed polygon through its corners; the last one need not repeat the first.
#[derive(Debug, Clone)]
pub struct Polygon {
    corners: Vec<[f64; 2]>,
    stroke: Stroke,
    fill: Option<Ink>,
    label: Option<String>,
}

impl Polygon {
    /// A dark outline, 1.4 px wide, without fill.
    pub fn new(corners: &[[f64; 2]]) -> Self {
        Self {
            corners: corners.to_vec(),
            stroke: Stroke::new(Color::INK, 1.4),
            fill: None,
            label: None,
        }
    }
}

builders!(Polygon: stroke, dashed, fill, label);

impl Mark for Polygon {
    fn name(&self) -> String {
        described("polygon", self.label.as_ref())
    }

    fn check(&self) -> Result<(), ReportError> {
        let name = self.name();
        check_some(&name, self.corners.len())?;
        check_finite(&name, "corners (x, y)", self.corners.as_flattened())?;
        check_positive(&name, "width", self.stroke.width)
    }

    fn extent(&self) -> Extent {
        Extent::of(self.corners.iter().copied())
    }

    fn draw(&self, canvas: &mut Canvas<'_>) {
        canvas.area(std::slice::from_ref(&self.corners), self.fill, Some(self.stroke));
    }

    fn legend(&self) -> Option<LegendKey> {
        LegendKey::new(self.label.as_ref(), Swatch::Area(self.fill, Some(self.stroke)))
    }
}
