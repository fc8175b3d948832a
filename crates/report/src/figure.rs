//! A figure: panels on a grid, drawn as SVG and PNG.

use std::path::Path;

use crate::data::Data;
use crate::error::ReportError;
use crate::files::{Drawn, write_atomically};
use crate::frame::Margins;
use crate::legend::LegendPlace;
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
    panel_size: [f64; 2],
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
const SVG_LIMIT: usize = 280_000;
/// Bytes that those pictures may take together.
const SVG_BUDGET: usize = 240_000;

impl Figure {
    /// An empty grid, filled row by row with [`Figure::with`]; a cell is 360 × 290 px.
    pub fn new(rows: usize, columns: usize) -> Self {
        let panel_size = [360.0, 290.0];
        Self { rows, columns, title: String::new(), panel_size, panels: Vec::new() }
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

    /// Makes each panel this large with its labels, in px (1 px = 0.75 pt).
    #[must_use]
    pub fn panel_size(mut self, width: f64, height: f64) -> Self {
        self.panel_size = [width, height];
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
        write_atomically(&drawn.path("svg"), drawn.svg.as_bytes())?;
        write_atomically(&drawn.path("png"), &to_png(&scene, png_scale(&scene))?)?;
        write_atomically(&drawn.path(drawn.data_extension), numbers.as_bytes())?;
        Ok(drawn)
    }

    fn name(&self) -> &str {
        if !self.title.is_empty() {
            return &self.title;
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
        let mut scene =
            Scene::new(width * self.columns as f64, height * self.rows as f64 + head + 4.0);
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
        Ok(scene)
    }

    /// Margins and legend places: once for a guessed area, then for the area that follows.
    fn plan(&self, head: f64) -> Result<(Vec<Margins>, Vec<LegendPlace>), ReportError> {
        let guess = [self.panel_size[0] - 90.0, self.panel_size[1] - 80.0];
        let panels = || self.panels.iter().enumerate();
        panels().try_for_each(|(i, panel)| panel.check(i))?;
        let first: Vec<Margins> = panels()
            .map(|(i, panel)| panel.margins(&self.lettered(i), guess, LegendPlace::Auto))
            .collect::<Result<_, _>>()?;
        let areas: Vec<Rect> = panels().map(|(i, _)| self.area(&first, i, head)).collect();
        let places: Vec<LegendPlace> =
            panels().map(|(i, panel)| panel.settle_legend(areas[i])).collect::<Result<_, _>>()?;
        let margins = panels()
            .map(|(i, panel)| {
                let size = [areas[i].width, areas[i].height];
                panel.margins(&self.lettered(i), size, places[i])
            })
            .collect::<Result<_, _>>()?;
        Ok((margins, places))
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
