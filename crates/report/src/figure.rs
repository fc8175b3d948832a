//! A figure: panels on a grid, drawn as SVG and PNG.

use std::path::Path;

use crate::data::Data;
use crate::error::ReportError;
use crate::files::{Drawn, write};
use crate::frame::Margins;
use crate::legend::{LegendPlace, draw_below, height_below};
use crate::mark::LegendKey;
use crate::panel::Panel;
use crate::raster::to_png;
use crate::scene::{Rect, Scene, Text};
use crate::space::Space;
use crate::svg::to_svg;

/// Panels on a grid of rows and columns, lettered if there is more than one.
#[derive(Debug)]
pub struct Figure {
    rows: usize,
    columns: usize,
    title: String,
    name: String,
    panel_size: [f64; 2],
    one_legend: bool,
    panels: Vec<Cell>,
}

/// A flat or a spatial panel.
#[derive(Debug)]
#[non_exhaustive]
pub enum Cell {
    /// Two axes.
    Flat(Panel),
    /// Three axes.
    Spatial(Space),
}

/// Pixels of the PNG across, at least.
const PNG_WIDTH: f64 = 1400.0;
/// Bytes of SVG above which the panels' marks become pictures.
const SVG_LIMIT: usize = 190_000;
/// Room left at both sides of the one legend, in px.
const EDGE: f64 = 12.0;
/// Bytes that those pictures may take together.
const SVG_BUDGET: usize = 160_000;

impl Figure {
    /// An empty grid, filled row by row with [`Figure::with`]; a cell is 360 × 290 px.
    pub fn new(rows: usize, columns: usize) -> Self {
        let panel_size = [360.0, 290.0];
        let (title, name, panels) = (String::new(), String::new(), Vec::new());
        Self { rows, columns, title, name, panel_size, one_legend: false, panels }
    }

    /// A figure of one panel of 560 × 380 px.
    pub fn single(panel: impl Into<Cell>) -> Self {
        Self::new(1, 1).panel_size(560.0, 380.0).with(panel)
    }

    /// Writes a title above all panels; it is also the picture's accessible name.
    #[must_use]
    pub fn title(mut self, title: &str) -> Self {
        title.clone_into(&mut self.title);
        self
    }

    /// Gives the figure a name for pages and screen readers that is not written in the picture.
    #[must_use]
    pub fn named(mut self, name: &str) -> Self {
        name.clone_into(&mut self.name);
        self
    }

    /// Makes each panel this large with its labels, in px (1 px = 0.75 pt).
    #[must_use]
    pub fn panel_size(mut self, width: f64, height: f64) -> Self {
        self.panel_size = [width, height];
        self
    }

    /// Shows what the panels' legends say once, below all of them.
    #[must_use]
    pub fn one_legend(mut self) -> Self {
        self.one_legend = true;
        self
    }

    /// Adds the next panel.
    #[must_use]
    pub fn with(mut self, panel: impl Into<Cell>) -> Self {
        self.panels.push(panel.into());
        self
    }

    /// The figure as SVG text, which needs nothing beside itself.
    ///
    /// # Errors
    /// Whatever cannot be drawn, named by mark and index; too many panels; too small a size.
    pub fn svg(&self) -> Result<String, ReportError> {
        self.light_svg(&self.scene(usize::MAX)?)
    }

    /// The figure as PNG bytes, twice as many pixels as px and at least 1400 across.
    ///
    /// # Errors
    /// As [`Figure::svg`].
    pub fn png(&self) -> Result<Vec<u8>, ReportError> {
        let scene = self.scene(usize::MAX)?;
        to_png(&scene, png_scale(&scene))
    }

    /// Writes `name.svg`, `name.png` and the numbers as `name.csv` or `name.json` into a folder,
    /// which is made if missing; each file appears whole or not at all.
    ///
    /// # Errors
    /// As [`Figure::svg`]; data that do not fit a table; a name that does not fit a file; a
    /// folder that cannot be written.
    pub fn write(&self, folder: &Path, name: &str, data: &Data) -> Result<Drawn, ReportError> {
        let scene = self.scene(usize::MAX)?;
        let drawn = Drawn::new(folder, name, self.name(), self.light_svg(&scene)?, data)?;
        let numbers = data.to_text(name)?;
        write(&drawn.path("svg"), drawn.svg.as_bytes())?;
        write(&drawn.path("png"), &to_png(&scene, png_scale(&scene))?)?;
        write(&drawn.path(drawn.data_extension), numbers.as_bytes())?;
        Ok(drawn)
    }

    pub(crate) fn name(&self) -> &str {
        if let Some(own) = [&self.name, &self.title].into_iter().find(|name| !name.is_empty()) {
            return own;
        }
        self.panels.iter().map(Cell::title).find(|title| !title.is_empty()).unwrap_or("figure")
    }

    /// The scene as SVG; if that is heavy, with the marks of heavy panels as pictures.
    fn light_svg(&self, scene: &Scene) -> Result<String, ReportError> {
        let svg = to_svg(scene, self.name())?;
        if svg.len() <= SVG_LIMIT {
            return Ok(svg);
        }
        to_svg(&self.scene(SVG_BUDGET / self.panels.len())?, self.name())
    }

    /// Everything drawn, the marks of a panel as a picture if above `budget` bytes of SVG.
    fn scene(&self, budget: usize) -> Result<Scene, ReportError> {
        let n_cells = self.rows * self.columns;
        if self.panels.is_empty() || self.panels.len() > n_cells {
            let found = self.panels.len();
            return Err(ReportError::Panels { rows: self.rows, columns: self.columns, found });
        }
        let [width, height] = self.panel_size;
        let head = if self.title.is_empty() { 0.0 } else { 30.0 };
        let body = head + height * self.rows as f64;
        let mut scene = Scene::new(width * self.columns as f64, body + 4.0);
        if !self.title.is_empty() {
            let text = Text::new([0.5 * scene.width, 21.0], &self.title, 15.0);
            scene.text(Text { bold: true, ..text });
        }
        let (margins, places) = self.plan(head)?;
        for (i, panel) in self.panels.iter().enumerate() {
            let area = self.area(&margins, i, head);
            if !(area.width >= 60.0 && area.height >= 50.0) {
                return Err(ReportError::TooSmall {
                    index: i,
                    width: area.width,
                    height: area.height,
                });
            }
            panel.draw(&mut scene, area, &self.lettered(i), places[i], budget)?;
        }
        let keys = self.shared_keys();
        if !keys.is_empty() {
            let (center, right, room) =
                (0.5 * scene.width, scene.width - EDGE, scene.width - 2.0 * EDGE);
            draw_below(&mut scene, [center, body], right, &keys, room);
            scene.height += height_below(&keys, room);
        }
        Ok(scene)
    }

    /// The keys of the one legend, each label once.
    fn shared_keys(&self) -> Vec<LegendKey> {
        let mut keys: Vec<LegendKey> = Vec::new();
        for key in self.panels.iter().filter(|_| self.one_legend).flat_map(Cell::keys) {
            if keys.iter().all(|known| known.label != key.label) {
                keys.push(key);
            }
        }
        keys
    }

    /// Margins and legend places: once for a guessed area, then for the areas that follow, as a
    /// legend below one panel makes all panels of its row lower.
    fn plan(&self, head: f64) -> Result<(Vec<Margins>, Vec<LegendPlace>), ReportError> {
        let guess = [self.panel_size[0] - 90.0, self.panel_size[1] - 80.0];
        let panels = || self.panels.iter().enumerate();
        panels().try_for_each(|(i, panel)| panel.check(i))?;
        let measure = |sizes: &[[f64; 2]], places: &[LegendPlace]| {
            panels()
                .map(|(i, panel)| panel.margins(&self.lettered(i), sizes[i], places[i]))
                .collect::<Result<Vec<Margins>, _>>()
        };
        let start = if self.one_legend { LegendPlace::Hidden } else { LegendPlace::Auto };
        let mut places = vec![start; self.panels.len()];
        let mut margins = measure(&vec![guess; self.panels.len()], &places)?;
        loop {
            let areas: Vec<Rect> = panels().map(|(i, _)| self.area(&margins, i, head)).collect();
            let before = places.clone();
            for (i, panel) in panels().filter(|(i, _)| before[*i] == LegendPlace::Auto) {
                places[i] = panel.settle_legend(areas[i])?;
            }
            let sizes: Vec<_> = areas.iter().map(|area| [area.width, area.height]).collect();
            margins = measure(&sizes, &places)?;
            // Only `Auto` changes, and only once, so that this ends.
            if places == before {
                return Ok((margins, places));
            }
        }
    }

    /// The data area of a panel.
    fn area(&self, margins: &[Margins], index: usize, head: f64) -> Rect {
        let [width, height] = self.panel_size;
        let (row, column) = (index / self.columns, index % self.columns);
        let around = self.shared(margins, row, column);
        Rect {
            x: column as f64 * width + around.left,
            y: head + row as f64 * height + around.top,
            width: width - around.left - around.right,
            height: height - around.top - around.bottom,
        }
    }

    /// The margins that line a panel up with its row and its column.
    fn shared(&self, margins: &[Margins], row: usize, column: usize) -> Margins {
        let mut around = Margins::default();
        for (i, margin) in margins.iter().enumerate() {
            if i / self.columns == row {
                around.top = around.top.max(margin.top);
                around.bottom = around.bottom.max(margin.bottom);
            }
            if i % self.columns == column {
                around.left = around.left.max(margin.left);
                around.right = around.right.max(margin.right);
            }
        }
        around
    }

    fn lettered(&self, index: usize) -> String {
        let title = self.panels[index].title();
        if self.panels.len() == 1 {
            return title.to_owned();
        }
        let letter = char::from(b'a' + (index % 26) as u8);
        format!("({letter}) {title}").trim_end().to_owned()
    }
}

fn png_scale(scene: &Scene) -> f64 {
    (PNG_WIDTH / scene.width).max(2.0)
}

impl Cell {
    fn title(&self) -> &str {
        match self {
            Self::Flat(panel) => panel.title_text(),
            Self::Spatial(space) => space.title_text(),
        }
    }

    fn keys(&self) -> Vec<LegendKey> {
        match self {
            Self::Flat(panel) => panel.keys(),
            Self::Spatial(space) => space.keys(),
        }
    }

    fn check(&self, index: usize) -> Result<(), ReportError> {
        match self {
            Self::Flat(panel) => panel.check(index),
            Self::Spatial(space) => space.check(index),
        }
    }

    fn settle_legend(&self, area: Rect) -> Result<LegendPlace, ReportError> {
        match self {
            Self::Flat(panel) => panel.settle_legend(area),
            Self::Spatial(space) => space.settle_legend(area),
        }
    }

    fn margins(
        &self,
        title: &str,
        size: [f64; 2],
        place: LegendPlace,
    ) -> Result<Margins, ReportError> {
        match self {
            Self::Flat(panel) => panel.margins(title, size, place),
            Self::Spatial(space) => space.margins(title, size, place),
        }
    }

    fn draw(
        &self,
        scene: &mut Scene,
        area: Rect,
        title: &str,
        place: LegendPlace,
        budget: usize,
    ) -> Result<(), ReportError> {
        match self {
            Self::Flat(panel) => panel.draw(scene, area, title, place, budget),
            Self::Spatial(space) => space.draw(scene, area, title, place, budget),
        }
    }
}

impl From<Panel> for Cell {
    fn from(panel: Panel) -> Self {
        Self::Flat(panel)
    }
}

impl From<Space> for Cell {
    fn from(space: Space) -> Self {
        Self::Spatial(space)
    }
}
