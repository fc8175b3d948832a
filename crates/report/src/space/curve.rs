//! Curves in space.

use super::view::View;
use super::{Body, Piece};
use crate::color::Color;
use crate::error::{ReportError, check_finite, check_positive, check_some};
use crate::mark::{LegendKey, Swatch, described};
use crate::scene::{Shape, Stroke};

/// A line through points in axis units.
#[derive(Debug, Clone)]
pub struct Curve {
    points: Vec<[f64; 3]>,
    color: Color,
    width: f64,
    dashed: bool,
    label: Option<String>,
}

impl Curve {
    /// A solid vermilion line, 2 px wide.
    pub fn new(points: &[[f64; 3]]) -> Self {
        let points = points.to_vec();
        Self { points, color: Color::VERMILION, width: 2.0, dashed: false, label: None }
    }

    fn stroke(&self) -> Stroke {
        let stroke = Stroke::new(self.color, self.width);
        if self.dashed { stroke.dashed() } else { stroke }
    }
}

builders!(Curve: color, width, dashed, label);

impl Body for Curve {
    fn name(&self) -> String {
        described("curve", self.label.as_ref())
    }

    fn check(&self) -> Result<(), ReportError> {
        let name = self.name();
        check_some(&name, self.points.len())?;
        check_finite(&name, "points (x, y, z)", self.points.as_flattened())?;
        check_positive(&name, "width", self.width)
    }

    fn points(&self) -> Vec<[f64; 3]> {
        self.points.clone()
    }

    fn pieces(&self, view: &View) -> Vec<Piece> {
        let piece = |ends: &[[f64; 3]]| {
            // A curve on a surface must win against the facets that it lies in.
            let depth = 0.5 * (view.depth(ends[0]) + view.depth(ends[1])) + 0.02;
            let rings = vec![ends.iter().map(|end| view.place(*end)).collect()];
            let stroke = Some(self.stroke());
            Piece { depth, shapes: vec![Shape::Path { rings, closed: false, fill: None, stroke }] }
        };
        self.points.windows(2).map(piece).collect()
    }

    fn legend(&self) -> Option<LegendKey> {
        LegendKey::new(self.label.as_ref(), Swatch::Line(self.stroke()))
    }
}
