//! Outlines that a model was trained on, as its weights name them.

use planar::Shape;
use serde::{Deserialize, Serialize};

/// An outline in its body frame, in m.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[non_exhaustive]
pub enum Outline {
    /// Vertices, counter-clockwise; edge i begins at vertex i.
    Polygon {
        /// In m.
        vertices: Vec<[f64; 2]>,
    },
    /// About the origin, with axes along x and y.
    Ellipse {
        /// Half axes along x and y, in m.
        semi_axes: [f64; 2],
    },
}

/// Outlines of two manifests that differ by less are one object, in m.
const TOLERANCE: f64 = 1e-5;

impl Outline {
    /// The outline of a shape.
    pub fn of(shape: &Shape) -> Self {
        match shape {
            Shape::Polygon(polygon) => {
                let vertices = polygon.vertices().iter().map(|vertex| [vertex.x, vertex.y]);
                Self::Polygon { vertices: vertices.collect() }
            }
            Shape::Ellipse(ellipse) => {
                let (x, y) = ellipse.semi_axes();
                Self::Ellipse { semi_axes: [x, y] }
            }
        }
    }

    /// Whether every number agrees within 10 µm.
    pub fn is_near(&self, other: &Self) -> bool {
        let near = |a: &[f64; 2], b: &[f64; 2]| (0..2).all(|k| (a[k] - b[k]).abs() <= TOLERANCE);
        match (self, other) {
            (Self::Polygon { vertices: one }, Self::Polygon { vertices: two }) => {
                one.len() == two.len() && one.iter().zip(two).all(|(a, b)| near(a, b))
            }
            (Self::Ellipse { semi_axes: one }, Self::Ellipse { semi_axes: two }) => near(one, two),
            _ => false,
        }
    }
}
