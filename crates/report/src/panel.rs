//! A panel of a figure: two axes and the marks drawn in them.

use crate::axis::Axis;
use crate::canvas::Canvas;
use crate::color::ColorScale;
use crate::error::ReportError;
use crate::frame::{
    Margins, Ruler, axis_margins, color_bar_width, draw_axes, draw_color_bar, draw_grid, draw_title,
};
use crate::legend::{LegendPlace, draw_legend, legend_box, legend_size};
use crate::mark::{Extent, LegendKey, Mark};
use crate::raster::flatten;
use crate::scene::{Rect, Scene, Shape};

/// Two axes and the marks drawn in them, the first at the bottom.
#[derive(Debug)]
pub struct Panel {
    x: Axis,
    y: Axis,
    title: String,
    equal_aspect: bool,
    legend: LegendPlace,
    marks: Vec<Box<dyn Mark>>,
}

impl Panel {
    /// An empty panel; an axis is made from its label, which carries the unit.
    pub fn new(x: impl Into<Axis>, y: impl Into<Axis>) -> Self {
        Self {
            x: x.into(),
            y: y.into(),
            title: String::new(),
            equal_aspect: false,
            legend: LegendPlace::Auto,
            marks: Vec::new(),
        }
    }

    /// Writes a title above the panel.
    #[must_use]
    pub fn title(mut self, title: &str) -> Self {
        title.clone_into(&mut self.title);
        self
    }

    /// Draws a unit of x as long as a unit of y.
    #[must_use]
    pub fn equal_aspect(mut self) -> Self {
        self.equal_aspect = true;
        self
    }

    /// Puts the legend in a place of its own.
    #[must_use]
    pub fn legend(mut self, place: LegendPlace) -> Self {
        self.legend = place;
        self
    }

    /// Adds a mark on top.
    #[must_use]
    pub fn with(mut self, mark: impl Mark + 'static) -> Self {
        self.marks.push(Box::new(mark));
        self
    }

    /// Adds many marks of one kind on top.
    #[must_use]
    pub fn with_all<M: Mark + 'static>(mut self, marks: impl IntoIterator<Item = M>) -> Self {
        self.marks.extend(marks.into_iter().map(|mark| Box::new(mark) as Box<dyn Mark>));
        self
    }

    pub(crate) fn title_text(&self) -> &str {
        &self.title
    }

    pub(crate) fn check(&self, index: usize) -> Result<(), ReportError> {
        if self.marks.is_empty() {
            return Err(ReportError::EmptyPanel { index, title: self.title.clone() });
        }
        for mark in &self.marks {
            mark.check()?;
            let extent = mark.extent();
            for (axis, range) in [(&self.x, extent.x), (&self.y, extent.y)] {
                if axis.logarithmic {
                    check_logarithmic(mark.as_ref(), axis, range)?;
                }
            }
        }
        Ok(())
    }

    /// The room about the data area in a cell of `size` px.
    pub(crate) fn margins(&self, title: &str, size: [f64; 2]) -> Result<Margins, ReportError> {
        let [x, y] = self.rulers()?;
        let inner = [size[0] - 90.0, size[1] - 80.0];
        let mut margins = axis_margins(&x, &y, title, inner);
        if let Some(scale) = self.color_scale() {
            margins.right = margins.right.max(color_bar_width(&scale, inner[1]) + 4.0);
        }
        let keys = self.keys();
        if self.legend == LegendPlace::Outside && !keys.is_empty() {
            margins.right += legend_size(&keys)[0] + 8.0;
        }
        Ok(margins)
    }

    /// Draws the panel about the data area; its marks take at most `budget` bytes of SVG.
    pub(crate) fn draw(
        &self,
        scene: &mut Scene,
        area: Rect,
        title: &str,
        budget: usize,
    ) -> Result<(), ReportError> {
        let [x, y] = self.rulers()?;
        let width = area.width;
        let area = if self.equal_aspect { equal_area(area, x.range, y.range) } else { area };
        draw_title(scene, title, &area, width);
        draw_grid(scene, &area, &x, &y);
        scene.shapes.push(Shape::ClipStart(area));
        let first = scene.shapes.len();
        let scales = (x.scale(area.x, area.right()), y.scale(area.bottom(), area.y));
        let mut canvas = Canvas { scene, x: scales.0, y: scales.1 };
        for mark in &self.marks {
            mark.draw(&mut canvas);
        }
        let keys = self.keys();
        let spot = legend_box(scene, first, &area, &keys, self.legend);
        lighten(scene, first, area, budget)?;
        scene.shapes.push(Shape::ClipEnd);
        draw_axes(scene, &area, &x, &y);
        if let Some(scale) = self.color_scale() {
            draw_color_bar(scene, &area, &scale);
        }
        if !keys.is_empty() {
            draw_legend(scene, &spot, &keys);
        }
        Ok(())
    }

    fn rulers(&self) -> Result<[Ruler<'_>; 2], ReportError> {
        let empty = Extent { x: None, y: None, pad: [false; 4] };
        let extent = self.marks.iter().fold(empty, |extent, mark| extent.with(mark.extent()));
        let [left, right, below, above] = extent.pad;
        let x = Ruler { axis: &self.x, range: self.x.resolve(extent.x, [left, right])? };
        let y = Ruler { axis: &self.y, range: self.y.resolve(extent.y, [below, above])? };
        Ok([x, y])
    }

    fn keys(&self) -> Vec<LegendKey> {
        self.marks.iter().filter_map(|mark| mark.legend()).collect()
    }

    fn color_scale(&self) -> Option<ColorScale> {
        self.marks.iter().find_map(|mark| mark.color_scale())
    }
}

fn check_logarithmic(
    mark: &dyn Mark,
    axis: &Axis,
    range: Option<(f64, f64)>,
) -> Result<(), ReportError> {
    let (name, label) = (mark.name(), axis.label.clone());
    if mark.needs_linear_axes() {
        return Err(ReportError::NeedsLinear { mark: name, axis: label });
    }
    match range {
        Some((value, _)) if value <= 0.0 => {
            Err(ReportError::NotPositive { mark: name, axis: label, value })
        }
        _ => Ok(()),
    }
}

/// The largest area with equal units in the middle of the given one.
fn equal_area(area: Rect, x: (f64, f64), y: (f64, f64)) -> Rect {
    let unit = (area.width / (x.1 - x.0)).min(area.height / (y.1 - y.0));
    let (width, height) = (unit * (x.1 - x.0), unit * (y.1 - y.0));
    let [center_x, center_y] = area.center();
    Rect { x: center_x - 0.5 * width, y: center_y - 0.5 * height, width, height }
}

/// Replaces the shapes from `first` on by one picture (texts excepted) if they are too many.
pub(crate) fn lighten(
    scene: &mut Scene,
    first: usize,
    area: Rect,
    budget: usize,
) -> Result<(), ReportError> {
    if scene.svg_weight(first) <= budget {
        return Ok(());
    }
    let is_text = |shape: &Shape| matches!(shape, Shape::Text(_));
    let (texts, drawn): (Vec<Shape>, Vec<Shape>) = scene.shapes.drain(first..).partition(is_text);
    scene.shapes.push(Shape::Image(flatten(&drawn, area, 2.0)?));
    scene.shapes.extend(texts);
    Ok(())
}
