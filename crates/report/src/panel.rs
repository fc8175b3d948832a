//! A panel of a figure: two axes and the marks drawn in them.

use crate::axis::Axis;
use crate::canvas::Canvas;
use crate::color::ColorScale;
use crate::error::ReportError;
use crate::frame::{
    Margins, Ruler, axis_margins, color_bar_width, draw_axes, draw_color_bar, draw_grid, draw_title,
};
use crate::legend::{
    LegendPlace, draw_below, draw_legend, height_below, is_crowded, legend_box, legend_size,
};
use crate::mark::{Extent, LegendKey, Mark};
use crate::raster::{encode_png, flatten};
use crate::scene::{Rect, Scene, Shape};

/// How much wider than its data area a panel's legend below may be.
const OVERHANG: f64 = 50.0;

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

    /// Where the legend goes if the data area is `area`.
    pub(crate) fn settle_legend(&self, area: Rect) -> Result<LegendPlace, ReportError> {
        if self.legend != LegendPlace::Auto {
            return Ok(self.legend);
        }
        let [x, y] = self.rulers()?;
        let area = self.data_area(area, &x, &y);
        let mut trial = Scene::new(0.0, 0.0);
        self.draw_marks(&mut trial, &area, &x, &y);
        let crowded = is_crowded(&trial, 0, &area, &self.keys());
        Ok(if crowded { LegendPlace::Below } else { LegendPlace::Auto })
    }

    /// The room about a data area of roughly `size` px.
    pub(crate) fn margins(
        &self,
        title: &str,
        size: [f64; 2],
        place: LegendPlace,
    ) -> Result<Margins, ReportError> {
        let [x, y] = self.rulers()?;
        let mut margins = axis_margins(&x, &y, title, size);
        if let Some(scale) = self.color_scale() {
            margins.right = margins.right.max(color_bar_width(&scale, size[1]) + 4.0);
        }
        let keys = self.keys();
        match place {
            LegendPlace::Outside if !keys.is_empty() => {
                margins.right += legend_size(&keys)[0] + 8.0;
            }
            LegendPlace::Below => margins.bottom += height_below(&keys, size[0] + OVERHANG),
            _ => {}
        }
        Ok(margins)
    }

    /// Draws the panel about the data area; its marks take at most `budget` bytes of SVG.
    pub(crate) fn draw(
        &self,
        scene: &mut Scene,
        area: Rect,
        title: &str,
        place: LegendPlace,
        budget: usize,
    ) -> Result<(), ReportError> {
        let [x, y] = self.rulers()?;
        let room = area;
        let area = self.data_area(room, &x, &y);
        draw_title(scene, title, &area, room.width);
        draw_grid(scene, &area, &x, &y);
        scene.shapes.push(Shape::ClipStart(area));
        let first = scene.shapes.len();
        self.draw_marks(scene, &area, &x, &y);
        let keys = self.keys();
        let spot = legend_box(scene, first, &area, &keys, place);
        let texts = take_texts(scene, first);
        lighten(scene, first, area, budget)?;
        scene.shapes.push(Shape::ClipEnd);
        draw_axes(scene, &area, &x, &y);
        scene.shapes.extend(texts);
        if let Some(scale) = self.color_scale() {
            draw_color_bar(scene, &area, &scale);
        }
        if place == LegendPlace::Below {
            let foot = axis_margins(&x, &y, title, [area.width, area.height]).bottom;
            let at = [area.center()[0], area.bottom() + foot];
            draw_below(scene, at, room.right() + 8.0, &keys, room.width + OVERHANG);
        } else if !keys.is_empty() && place != LegendPlace::Hidden {
            draw_legend(scene, &spot, &keys);
        }
        Ok(())
    }

    fn draw_marks(&self, scene: &mut Scene, area: &Rect, x: &Ruler<'_>, y: &Ruler<'_>) {
        let (x, y) = (x.scale(area.x, area.right()), y.scale(area.bottom(), area.y));
        let mut canvas = Canvas { scene, x, y };
        for mark in &self.marks {
            mark.draw(&mut canvas);
        }
    }

    /// The largest part of the area with equal units, at its top, if they are to be equal.
    fn data_area(&self, area: Rect, x: &Ruler<'_>, y: &Ruler<'_>) -> Rect {
        if !self.equal_aspect {
            return area;
        }
        let (x, y) = (x.range.1 - x.range.0, y.range.1 - y.range.0);
        let unit = (area.width / x).min(area.height / y);
        let (width, height) = (unit * x, unit * y);
        Rect { x: area.center()[0] - 0.5 * width, y: area.y, width, height }
    }

    fn rulers(&self) -> Result<[Ruler<'_>; 2], ReportError> {
        let empty = Extent { x: None, y: None, pad: [false; 4] };
        let extent = self.marks.iter().fold(empty, |extent, mark| extent.with(mark.extent()));
        let [left, right, below, above] = extent.pad;
        let x = Ruler { axis: &self.x, range: self.x.resolve(extent.x, [left, right])? };
        let y = Ruler { axis: &self.y, range: self.y.resolve(extent.y, [below, above])? };
        Ok([x, y])
    }

    pub(crate) fn keys(&self) -> Vec<LegendKey> {
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

/// Takes the texts from `first` on out of the scene, which are neither clipped nor rasterised, and
/// the spots, which lie above all marks.
pub(crate) fn take_texts(scene: &mut Scene, first: usize) -> Vec<Shape> {
    let is_text = |shape: &mut Shape| matches!(shape, Shape::Text(_) | Shape::Spot { .. });
    scene.shapes.extract_if(first.., is_text).collect()
}

/// Replaces the shapes from `first` on by one picture if they are too many, as sharp as the
/// budget in bytes allows.
pub(crate) fn lighten(
    scene: &mut Scene,
    first: usize,
    area: Rect,
    budget: usize,
) -> Result<(), ReportError> {
    if scene.svg_weight(first) <= budget {
        return Ok(());
    }
    let drawn: Vec<Shape> = scene.shapes.drain(first..).collect();
    let mut scale = 2.0;
    loop {
        let image = flatten(&drawn, area, scale)?;
        // Base64 takes four bytes for three.
        let size = encode_png(image.columns, image.rows, &image.rgba)?.len() / 3 * 4;
        if size <= budget || scale <= 1.0 {
            scene.shapes.push(Shape::Image(image));
            return Ok(());
        }
        scale = (scale * (budget as f64 / size as f64).sqrt() * 0.95).max(1.0);
    }
}
