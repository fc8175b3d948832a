//! Texts over parts of a drawing.

use super::{Extent, Mark};
use crate::canvas::Canvas;
use crate::error::{ReportError, check_finite, check_positive};

/// Texts that a page shows over regions of a panel: under the pointer, a finger or the arrow keys.
///
/// Nothing of it is seen in the picture itself.
#[derive(Debug, Clone, Default)]
pub struct Hover {
    areas: Vec<Area>,
    discs: Vec<([f64; 2], f64, String)>,
}

/// A polygon with its text.
#[derive(Debug, Clone)]
struct Area {
    corners: Vec<[f64; 2]>,
    text: String,
    /// Which cell of a map it is.
    cell: Vec<usize>,
}

impl Hover {
    /// No text yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Shows a text over a polygon; lines end with `\n`.
    #[must_use]
    pub fn area(mut self, corners: &[[f64; 2]], text: &str) -> Self {
        let (corners, text) = (corners.to_vec(), text.to_owned());
        self.areas.push(Area { corners, text, cell: Vec::new() });
        self
    }

    /// Shows a text over an upright rectangle that is a cell of the drawing's
    /// [`CellsOf`](crate::CellsOf), by its index along each of its axes.
    #[must_use]
    pub fn cell_of(mut self, low: [f64; 2], high: [f64; 2], text: &str, cell: &[usize]) -> Self {
        self = self.cell(low, high, text);
        if let Some(area) = self.areas.last_mut() {
            cell.clone_into(&mut area.cell);
        }
        self
    }

    /// Shows a text over an upright rectangle between two corners.
    #[must_use]
    pub fn cell(self, low: [f64; 2], high: [f64; 2], text: &str) -> Self {
        self.area(&[low, [high[0], low[1]], high, [low[0], high[1]]], text)
    }

    /// Shows a text over a disc of a radius in px.
    #[must_use]
    pub fn disc(mut self, center: [f64; 2], radius: f64, text: &str) -> Self {
        self.discs.push((center, radius, text.to_owned()));
        self
    }
}

impl Mark for Hover {
    fn name(&self) -> String {
        "hover texts".to_owned()
    }

    fn check(&self) -> Result<(), ReportError> {
        let name = self.name();
        for Area { corners, .. } in &self.areas {
            check_finite(&name, "corners (x, y)", corners.as_flattened())?;
        }
        for (center, radius, _) in &self.discs {
            check_finite(&name, "centers (x, y)", center)?;
            check_positive(&name, "radius", *radius)?;
        }
        Ok(())
    }

    fn extent(&self) -> Extent {
        Extent::of([])
    }

    fn draw(&self, canvas: &mut Canvas<'_>) {
        for Area { corners, text, cell } in &self.areas {
            canvas.spot(corners, text, cell);
        }
        for (center, radius, text) in &self.discs {
            canvas.round_spot(*center, *radius, text);
        }
    }
}
