//! Upright bars from zero.

use super::{Extent, LegendKey, Mark, Swatch, described, pairs};
use crate::canvas::Canvas;
use crate::color::Color;
use crate::error::{ReportError, check_columns, check_positive};
use crate::scene::Ink;

/// Bars from 0 to `heights[i]` about `x[i]`; name the positions with [`Axis::names`].
///
/// [`Axis::names`]: crate::Axis::names
#[derive(Debug, Clone)]
pub struct Bars {
    x: Vec<f64>,
    heights: Vec<f64>,
    width: f64,
    color: Color,
    label: Option<String>,
}

impl Bars {
    /// Blue bars, `width` wide in units of the x axis.
    pub fn new(x: &[f64], heights: &[f64], width: f64) -> Self {
        let (x, heights) = (x.to_vec(), heights.to_vec());
        Self { x, heights, width, color: Color::BLUE, label: None }
    }
}

builders!(Bars: color, label);

impl Mark for Bars {
    fn name(&self) -> String {
        described("bars", self.label.as_ref())
    }

    fn check(&self) -> Result<(), ReportError> {
        let name = self.name();
        check_columns(&name, &[("x", &self.x), ("heights", &self.heights)])?;
        check_positive(&name, "width", self.width)
    }

    fn extent(&self) -> Extent {
        let half = 0.5 * self.width;
        let ends = pairs(&self.x, &self.heights)
            .flat_map(|[x, height]| [[x - half, 0.0], [x + half, height]]);
        let mut extent = Extent::of(ends);
        if let Some((low, high)) = extent.y {
            extent.pad[2] = low < 0.0;
            extent.pad[3] = high > 0.0;
        }
        extent
    }

    fn draw(&self, canvas: &mut Canvas<'_>) {
        let half = 0.5 * self.width;
        for [x, height] in pairs(&self.x, &self.heights) {
            let bar =
                vec![[x - half, 0.0], [x - half, height], [x + half, height], [x + half, 0.0]];
            canvas.area(&[bar], Some(self.color.into()), None);
        }
    }

    fn legend(&self) -> Option<LegendKey> {
        LegendKey::new(self.label.as_ref(), Swatch::Area(Some(Ink::from(self.color)), None))
    }

    fn needs_linear_axes(&self) -> bool {
        true
    }
}
