//! Shaded surfaces and wireframes.

use std::collections::BTreeSet;

use super::view::View;
use super::{Body, Piece};
use crate::color::Color;
use crate::error::{ReportError, check_finite, check_positive, check_some};
use crate::mark::{LegendKey, Swatch, described};
use crate::scene::{Ink, Shape, Stroke};

/// Flat facets between points in axis units, shaded, or only their edges.
#[derive(Debug, Clone)]
pub struct Surface {
    points: Vec<[f64; 3]>,
    facets: Vec<Vec<usize>>,
    ink: Ink,
    wireframe: bool,
    edges: bool,
    convex: bool,
    label: Option<String>,
}

impl Surface {
    /// Polygons given by the indices of their corners.
    pub fn facets(points: &[[f64; 3]], facets: &[Vec<usize>]) -> Self {
        Self {
            points: points.to_vec(),
            facets: facets.to_vec(),
            ink: Color::SKY.into(),
            wireframe: false,
            edges: false,
            convex: false,
            label: None,
        }
    }

    /// Triangles given by the indices of their corners.
    pub fn triangles(points: &[[f64; 3]], triangles: &[[usize; 3]]) -> Self {
        let facets: Vec<Vec<usize>> = triangles.iter().map(|corners| corners.to_vec()).collect();
        Self::facets(points, &facets)
    }

    /// Quadrilaterals between `columns + 1` by `rows + 1` points of a parametric surface with
    /// both parameters from 0 to 1.
    pub fn parametric(
        columns: usize,
        rows: usize,
        mut point: impl FnMut(f64, f64) -> [f64; 3],
    ) -> Self {
        let at = |i: usize, n: usize| i as f64 / n as f64;
        let points: Vec<[f64; 3]> = (0..=rows)
            .flat_map(|row| (0..=columns).map(move |column| (row, column)))
            .map(|(row, column)| point(at(column, columns), at(row, rows)))
            .collect();
        let facets: Vec<Vec<usize>> = (0..rows)
            .flat_map(|row| (0..columns).map(move |column| row * (columns + 1) + column))
            .map(|i| vec![i, i + 1, i + columns + 2, i + columns + 1])
            .collect();
        Self::facets(&points, &facets)
    }

    /// Draws only the edges, e.g. to compare with a shaded surface.
    #[must_use]
    pub fn wireframe(mut self) -> Self {
        self.wireframe = true;
        self
    }

    /// Draws thin edges on the shaded facets.
    #[must_use]
    pub fn edges(mut self) -> Self {
        self.edges = true;
        self
    }

    /// Leaves out the facets that the body hides if it is convex and opaque: half the bytes.
    #[must_use]
    pub fn convex(mut self) -> Self {
        self.convex = true;
        self
    }

    /// Each edge once, so that it is as dark as any other.
    fn edge_pieces(&self, view: &View) -> Vec<Piece> {
        let mut edges = BTreeSet::new();
        for facet in &self.facets {
            for (i, corner) in facet.iter().enumerate() {
                let next = facet[(i + 1) % facet.len()];
                edges.insert((*corner.min(&next), *corner.max(&next)));
            }
        }
        let stroke = Some(Stroke::new(self.ink, 0.9));
        let piece = |(a, b): (usize, usize)| {
            let ends = [self.points[a], self.points[b]];
            let depth = 0.5 * (view.depth(ends[0]) + view.depth(ends[1]));
            let rings = vec![ends.iter().map(|end| view.place(*end)).collect()];
            Piece { depth, shapes: vec![Shape::Path { rings, closed: false, fill: None, stroke }] }
        };
        edges.into_iter().map(piece).collect()
    }

    fn facet(&self, view: &View, corners: &[[f64; 3]]) -> Shape {
        let rings = vec![corners.iter().map(|corner| view.place(*corner)).collect()];
        let color = self.ink.color.lit(0.5 + 0.75 * view.light(corners));
        let fill = Ink { color, ..self.ink };
        // The outline in the fill's own color closes the seams between facets.
        let stroke = if self.edges {
            Some(Stroke::new(Ink::new(self.ink.color.lit(0.45), self.ink.opacity), 0.7))
        } else if self.ink.opacity >= 1.0 {
            Some(Stroke::new(color, 0.6))
        } else {
            None
        };
        Shape::Path { rings, closed: true, fill: Some(fill), stroke }
    }
}

builders!(Surface: ink, label);

impl Body for Surface {
    fn name(&self) -> String {
        described("surface", self.label.as_ref())
    }

    fn check(&self) -> Result<(), ReportError> {
        let name = self.name();
        check_some(&name, self.facets.len())?;
        check_finite(&name, "points (x, y, z)", self.points.as_flattened())?;
        check_positive(&name, "opacity", self.ink.opacity)?;
        check_some(&name, self.facets.iter().map(Vec::len).min().unwrap_or(0))?;
        let largest = self.facets.iter().flatten().copied().max().unwrap_or(0);
        if largest < self.points.len() {
            return Ok(());
        }
        Err(ReportError::Parameter {
            mark: name,
            field: "corner index",
            expected: "below the number of points",
            value: largest as f64,
        })
    }

    fn points(&self) -> Vec<[f64; 3]> {
        self.points.clone()
    }

    fn pieces(&self, view: &View) -> Vec<Piece> {
        if self.wireframe {
            return self.edge_pieces(view);
        }
        let piece = |facet: &Vec<usize>| {
            let corners: Vec<[f64; 3]> = facet.iter().map(|i| self.points[*i]).collect();
            // By its farthest corner, so that what lies on a facet is drawn over it.
            let depth = corners.iter().map(|c| view.depth(*c)).fold(f64::INFINITY, f64::min);
            let shapes = vec![self.facet(view, &corners)];
            Piece { depth, shapes }
        };
        let n = self.points.len() as f64;
        let inside = [0, 1, 2].map(|i| self.points.iter().map(|p| p[i]).sum::<f64>() / n);
        let seen = |facet: &&Vec<usize>| {
            let corners: Vec<[f64; 3]> = facet.iter().map(|i| self.points[*i]).collect();
            !self.convex || view.sees(&corners, inside)
        };
        self.facets.iter().filter(seen).map(piece).collect()
    }

    fn legend(&self) -> Option<LegendKey> {
        let swatch = if self.wireframe {
            Swatch::Line(Stroke::new(self.ink.color, 1.2))
        } else {
            Swatch::Area(Some(self.ink), None)
        };
        LegendKey::new(self.label.as_ref(), swatch)
    }
}
