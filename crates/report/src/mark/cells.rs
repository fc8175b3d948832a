//! Rectangles of any width colored by value, as a heat map over uneven cells.

use super::{Extent, Mark};
use crate::canvas::Canvas;
use crate::color::{Color, ColorMap, ColorScale};
use crate::error::{ReportError, check_finite, check_positive, check_some};
use crate::scene::{Ink, Stroke};

/// Rectangles about the values of some cells of a plane, with a color bar.
#[derive(Debug, Clone)]
pub struct Cells {
    cells: Vec<ColoredCell>,
    map: ColorMap,
    range: Option<(f64, f64)>,
    label: String,
}

/// A rectangle with its value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ColoredCell {
    /// Left and right end.
    pub x: [f64; 2],
    /// Lower and upper end.
    pub y: [f64; 2],
    /// The value that its color stands for.
    pub value: f64,
}

impl Cells {
    /// Diverging colors about 0; the color bar shows `label`, which carries the unit.
    pub fn new(cells: Vec<ColoredCell>, label: &str) -> Self {
        Self { cells, map: ColorMap::Diverging, range: None, label: label.to_owned() }
    }

    /// Uses another color map.
    #[must_use]
    pub fn map(mut self, map: ColorMap) -> Self {
        self.map = map;
        self
    }

    /// The values at the two ends of the color bar, e.g. to share it between panels.
    #[must_use]
    pub fn range(mut self, low: f64, high: f64) -> Self {
        self.range = Some((low, high));
        self
    }

    fn scale(&self) -> ColorScale {
        let values = self.cells.iter().map(|cell| cell.value);
        ColorScale::fit(self.map, self.range, Some(self.label.clone()), values)
    }
}

impl Mark for Cells {
    fn name(&self) -> String {
        format!("cells `{}`", self.label)
    }

    fn check(&self) -> Result<(), ReportError> {
        let name = self.name();
        check_some(&name, self.cells.len())?;
        for ColoredCell { x, y, value } in &self.cells {
            check_finite(&name, "cells (x, x, y, y, value)", &[x[0], x[1], y[0], y[1], *value])?;
        }
        let Some((low, high)) = self.range else { return Ok(()) };
        check_finite(&name, "range", &[low, high])?;
        check_positive(&name, "range width", high - low)
    }

    fn extent(&self) -> Extent {
        let corners = self.cells.iter().flat_map(|c| [[c.x[0], c.y[0]], [c.x[1], c.y[1]]]);
        Extent { pad: [false; 4], ..Extent::of(corners) }
    }

    fn draw(&self, canvas: &mut Canvas<'_>) {
        let scale = self.scale();
        // So that a cell about 0 can be told from none.
        let edge = Stroke::new(Color::GRAY, 0.6);
        for ColoredCell { x, y, value } in &self.cells {
            let ring = vec![[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]]];
            canvas.area(&[ring], Some(Ink::from(scale.color(*value))), Some(edge));
        }
    }

    fn color_scale(&self) -> Option<ColorScale> {
        Some(self.scale())
    }

    fn needs_linear_axes(&self) -> bool {
        true
    }
}
