//! Arrows in space, such as normals of a surface.

use super::view::View;
use super::{Body, Piece};
use crate::canvas::push_arrow;
use crate::color::Color;
use crate::error::{ReportError, check_finite, check_length, check_positive, check_some};
use crate::mark::{LegendKey, Swatch, described};
use crate::scene::{Scene, Stroke};

/// Arrows from `tails[i]` to `tails[i] + vectors[i]`, both in axis units.
#[derive(Debug, Clone)]
pub struct SpatialArrows {
    tails: Vec<[f64; 3]>,
    vectors: Vec<[f64; 3]>,
    stroke: Stroke,
    label: Option<String>,
}

impl SpatialArrows {
    /// Dark arrows, 1.4 px wide.
    pub fn new(tails: &[[f64; 3]], vectors: &[[f64; 3]]) -> Self {
        let (tails, vectors) = (tails.to_vec(), vectors.to_vec());
        Self { tails, vectors, stroke: Stroke::new(Color::INK, 1.4), label: None }
    }

    fn ends(&self) -> impl Iterator<Item = [[f64; 3]; 2]> + '_ {
        let arrows = self.tails.iter().zip(&self.vectors);
        arrows.map(|(t, v)| [*t, [t[0] + v[0], t[1] + v[1], t[2] + v[2]]])
    }
}

builders!(SpatialArrows: stroke, label);

impl Body for SpatialArrows {
    fn name(&self) -> String {
        described("spatial arrows", self.label.as_ref())
    }

    fn check(&self) -> Result<(), ReportError> {
        let name = self.name();
        check_some(&name, self.tails.len())?;
        check_length(&name, "vectors", self.tails.len(), self.vectors.len())?;
        check_finite(&name, "tails (x, y, z)", self.tails.as_flattened())?;
        check_finite(&name, "vectors (x, y, z)", self.vectors.as_flattened())?;
        check_positive(&name, "width", self.stroke.width)
    }

    fn points(&self) -> Vec<[f64; 3]> {
        self.ends().flatten().collect()
    }

    fn pieces(&self, view: &View) -> Vec<Piece> {
        let piece = |[tail, tip]: [[f64; 3]; 2]| {
            // Only the outermost point tells whether an arrow that starts on a surface is hidden.
            let depth = 0.5 * (view.depth(tail) + view.depth(tip)) + 0.02;
            let mut scene = Scene::new(0.0, 0.0);
            push_arrow(&mut scene, view.place(tail), view.place(tip), self.stroke);
            Piece { depth, shapes: scene.shapes }
        };
        self.ends().map(piece).collect()
    }

    fn legend(&self) -> Option<LegendKey> {
        LegendKey::new(self.label.as_ref(), Swatch::Arrow(self.stroke))
    }
}
