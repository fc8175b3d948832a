//! A heat map: a small embedded picture, one pixel a cell.

use super::{Extent, Mark};
use crate::canvas::Canvas;
use crate::color::{ColorMap, ColorScale};
use crate::error::{ReportError, check_finite, check_positive};
use crate::grid::Grid;

/// A grid whose cells are colored by value, with a color bar.
#[derive(Debug, Clone)]
pub struct HeatMap {
    grid: Grid,
    map: ColorMap,
    range: Option<(f64, f64)>,
    label: String,
}

impl HeatMap {
    /// A viridis map; the color bar shows `label`, which carries the unit.
    pub fn new(grid: Grid, label: &str) -> Self {
        Self { grid, map: ColorMap::Viridis, range: None, label: label.to_owned() }
    }

    /// Uses another color map; a diverging one is centered at 0.
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
        ColorScale::fit(self.map, self.range, Some(self.label.clone()), self.grid.visible())
    }
}

impl Mark for HeatMap {
    fn name(&self) -> String {
        format!("heat map `{}`", self.label)
    }

    fn check(&self) -> Result<(), ReportError> {
        let name = self.name();
        self.grid.check(&name)?;
        let Some((low, high)) = self.range else { return Ok(()) };
        check_finite(&name, "range", &[low, high])?;
        check_positive(&name, "range width", high - low)
    }

    fn extent(&self) -> Extent {
        Extent { x: Some(self.grid.x), y: Some(self.grid.y), pad: [false; 4] }
    }

    fn draw(&self, canvas: &mut Canvas<'_>) {
        let (grid, scale) = (&self.grid, self.scale());
        let from_top = (0..grid.rows).rev();
        let cells = from_top.flat_map(|row| row * grid.columns..(row + 1) * grid.columns);
        let rgba = cells
            .flat_map(|cell| {
                let color = scale.color(grid.values[cell]);
                [color.r, color.g, color.b, if grid.is_shown(cell) { 255 } else { 0 }]
            })
            .collect();
        let (low, high) = ([grid.x.0, grid.y.0], [grid.x.1, grid.y.1]);
        canvas.image(low, high, [grid.columns, grid.rows], rgba);
    }

    fn color_scale(&self) -> Option<ColorScale> {
        Some(self.scale())
    }

    fn needs_linear_axes(&self) -> bool {
        true
    }
}
