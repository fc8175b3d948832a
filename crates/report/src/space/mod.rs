//! A spatial panel: bodies in a box with three axes, seen from a distance.

use std::fmt::Debug;

use crate::axis::Axis;
use crate::color::Color;
use crate::error::ReportError;
use crate::font::text_width;
use crate::frame::{Margins, draw_title, title_height};
use crate::legend::{LegendPlace, draw_below, draw_legend, height_below, is_crowded, legend_box};
use crate::mark::LegendKey;
use crate::panel::lighten;
use crate::scene::{Anchor, Ink, Rect, Scene, Shape, Stroke, Text};
use crate::style::{FRAME, GRID, NORMAL, SMALL};
use view::View;

pub(crate) mod arrows;
pub(crate) mod curve;
pub(crate) mod surface;
pub(crate) mod view;

/// Most ticks on an axis.
const TICKS: f64 = 4.0;
/// Room below the box for its axes.
const AXES: f64 = 50.0;

/// Three axes and the bodies drawn in their box, nearer ones over farther ones.
#[derive(Debug)]
pub struct Space {
    axes: [Axis; 3],
    title: String,
    azimuth: f64,
    elevation: f64,
    equal_aspect: bool,
    legend: LegendPlace,
    bodies: Vec<Box<dyn Body>>,
}

/// Something drawn in a spatial panel.
pub trait Body: Debug + Send + Sync {
    /// The kind and label, for messages.
    fn name(&self) -> String;

    /// Refuses what cannot be drawn.
    ///
    /// # Errors
    /// Non-finite values, lengths that differ, no data, or a parameter out of range.
    fn check(&self) -> Result<(), ReportError>;

    /// Points that the box must hold, in axis units.
    fn points(&self) -> Vec<[f64; 3]>;

    /// The body cut into pieces that can be sorted by depth.
    fn pieces(&self, view: &View) -> Vec<Piece>;

    /// The body's line in the legend, if it has a label.
    fn legend(&self) -> Option<LegendKey> {
        None
    }
}

/// A piece of a body in the picture with its depth, larger for nearer.
#[derive(Debug)]
pub struct Piece {
    pub(crate) depth: f64,
    pub(crate) shapes: Vec<Shape>,
}

impl Space {
    /// An empty box; an axis is made from its label, which carries the unit.
    pub fn new(x: impl Into<Axis>, y: impl Into<Axis>, z: impl Into<Axis>) -> Self {
        Self {
            axes: [x.into(), y.into(), z.into()],
            title: String::new(),
            azimuth: 35f64.to_radians(),
            elevation: 24f64.to_radians(),
            equal_aspect: false,
            legend: LegendPlace::Auto,
            bodies: Vec::new(),
        }
    }

    /// Writes a title above the panel.
    #[must_use]
    pub fn title(mut self, title: &str) -> Self {
        title.clone_into(&mut self.title);
        self
    }

    /// Looks from an azimuth about z (0 along x) and an elevation within ±π/2, both in rad.
    #[must_use]
    pub fn view(mut self, azimuth: f64, elevation: f64) -> Self {
        (self.azimuth, self.elevation) = (azimuth, elevation);
        self
    }

    /// Draws a unit equally long on all axes; otherwise the box is a cube.
    #[must_use]
    pub fn equal_aspect(mut self) -> Self {
        self.equal_aspect = true;
        self
    }

    /// Puts the legend in a place of its own, inside or below.
    #[must_use]
    pub fn legend(mut self, place: LegendPlace) -> Self {
        self.legend = place;
        self
    }

    /// Adds a body.
    #[must_use]
    pub fn with(mut self, body: impl Body + 'static) -> Self {
        self.bodies.push(Box::new(body));
        self
    }

    pub(crate) fn title_text(&self) -> &str {
        &self.title
    }

    pub(crate) fn check(&self, index: usize) -> Result<(), ReportError> {
        if self.bodies.is_empty() {
            return Err(ReportError::EmptyPanel { index, title: self.title.clone() });
        }
        self.bodies.iter().try_for_each(|body| body.check())?;
        let name = format!("panel {index} (`{}`)", self.title);
        crate::error::check_finite(&name, "view", &[self.azimuth, self.elevation])?;
        if let Some(axis) = self.axes.iter().find(|axis| axis.logarithmic) {
            let axis = axis.label.clone();
            return Err(ReportError::NeedsLinear { mark: name, axis });
        }
        self.ranges().map(|_| ())
    }

    /// Where the legend goes if the box is drawn in `area`.
    pub(crate) fn settle_legend(&self, area: Rect) -> Result<LegendPlace, ReportError> {
        if self.legend != LegendPlace::Auto {
            return Ok(self.legend);
        }
        let mut trial = Scene::new(0.0, 0.0);
        self.draw_bodies(&mut trial, &self.view_in(area)?);
        let crowded = is_crowded(&trial, 0, &area, &self.keys());
        Ok(if crowded { LegendPlace::Below } else { LegendPlace::Auto })
    }

    /// The room about a box of roughly `size` px.
    pub(crate) fn margins(
        &self,
        title: &str,
        size: [f64; 2],
        place: LegendPlace,
    ) -> Result<Margins, ReportError> {
        let upright = self.axes[2].ticks(self.ranges()?[2], TICKS).major;
        let left = widest(&upright) + 18.0 + NORMAL + 6.0;
        let legend = match place {
            LegendPlace::Below => height_below(&self.keys(), size[0]),
            _ => 0.0,
        };
        let top = title_height(title, size[0]);
        Ok(Margins { left, right: 44.0, top, bottom: AXES + legend })
    }

    pub(crate) fn draw(
        &self,
        scene: &mut Scene,
        area: Rect,
        title: &str,
        place: LegendPlace,
        budget: usize,
    ) -> Result<(), ReportError> {
        let view = self.view_in(area)?;
        draw_title(scene, title, &Rect { x: area.x - 30.0, ..area }, area.width);
        self.draw_walls(scene, &view);
        let first = scene.shapes.len();
        self.draw_bodies(scene, &view);
        let keys = self.keys();
        let spot = legend_box(scene, first, &area, &keys, place);
        lighten(scene, first, area, budget)?;
        if place == LegendPlace::Below {
            let at = [area.center()[0], area.bottom() + AXES];
            draw_below(scene, at, area.right() + 40.0, &keys, area.width);
        } else if !keys.is_empty() && place != LegendPlace::Hidden {
            draw_legend(scene, &spot, &keys);
        }
        Ok(())
    }

    fn view_in(&self, area: Rect) -> Result<View, ReportError> {
        let angles = [self.azimuth, self.elevation];
        Ok(View::new(self.ranges()?, self.equal_aspect, angles, area))
    }

    pub(crate) fn keys(&self) -> Vec<LegendKey> {
        self.bodies.iter().filter_map(|body| body.legend()).collect()
    }

    fn draw_bodies(&self, scene: &mut Scene, view: &View) {
        let mut pieces: Vec<Piece> =
            self.bodies.iter().flat_map(|body| body.pieces(view)).collect();
        pieces.sort_by(|a, b| a.depth.total_cmp(&b.depth));
        scene.shapes.extend(pieces.into_iter().flat_map(|piece| piece.shapes));
    }

    fn ranges(&self) -> Result<[(f64, f64); 3], ReportError> {
        let points: Vec<[f64; 3]> = self.bodies.iter().flat_map(|body| body.points()).collect();
        let range = |i: usize| {
            let ends = |(low, high): (f64, f64), p: &[f64; 3]| (low.min(p[i]), high.max(p[i]));
            let data = points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), ends);
            self.axes[i].resolve(Some(data), [true; 2])
        };
        Ok([range(0)?, range(1)?, range(2)?])
    }

    /// The three far walls with their grids, and the three labelled axes.
    fn draw_walls(&self, scene: &mut Scene, view: &View) {
        let ticks = [0, 1, 2].map(|i| self.axes[i].ticks(view.ranges[i], TICKS).major);
        for wall in 0..3 {
            let far = view.far_side(wall);
            let (u, v) = ((wall + 1) % 3, (wall + 2) % 3);
            let on_wall = |a: f64, b: f64| {
                let mut point = [0.0; 3];
                (point[wall], point[u], point[v]) = (far, a, b);
                view.place(point)
            };
            let ((u0, u1), (v0, v1)) = (view.ranges[u], view.ranges[v]);
            let corners = vec![on_wall(u0, v0), on_wall(u1, v0), on_wall(u1, v1), on_wall(u0, v1)];
            let outline = Some(Stroke::new(Color::rgb(190, 190, 190), 1.0));
            let fill = Some(Ink::from(Color::rgb(250, 250, 250)));
            scene.path(corners, true, fill, outline);
            let grid = Stroke::new(GRID, 1.0);
            for (at, _) in &ticks[u] {
                scene.line(on_wall(*at, v0), on_wall(*at, v1), grid);
            }
            for (at, _) in &ticks[v] {
                scene.line(on_wall(u0, *at), on_wall(u1, *at), grid);
            }
        }
        let mut taken = Vec::new();
        for (i, ticks) in ticks.iter().enumerate() {
            draw_spatial_axis(scene, view, i, &self.axes[i].label, ticks, &mut taken);
        }
    }
}

fn widest(ticks: &[(f64, String)]) -> f64 {
    ticks.iter().map(|(_, text)| text_width(text, SMALL, false)).fold(0.0, f64::max)
}

/// One axis along the edge of the box where it hides nothing, labelled away from the box;
/// `taken` are the places of the labels so far.
fn draw_spatial_axis(
    scene: &mut Scene,
    view: &View,
    axis: usize,
    label: &str,
    ticks: &[(f64, String)],
    taken: &mut Vec<[f64; 2]>,
) {
    let edge = view.axis_edge(axis);
    let at = |value: f64| {
        let mut point = edge;
        point[axis] = value;
        view.place(point)
    };
    let (start, end) = (at(view.ranges[axis].0), at(view.ranges[axis].1));
    let stroke = Stroke::new(FRAME, 1.0);
    scene.line(start, end, stroke);
    let out = view.outward(start, end);
    let anchor = match out[0] {
        x if x > 0.4 => Anchor::Start,
        x if x < -0.4 => Anchor::End,
        _ => Anchor::Middle,
    };
    let others = taken.clone();
    for (value, name) in ticks {
        let [x, y] = at(*value);
        scene.line([x, y], [x + 4.0 * out[0], y + 4.0 * out[1]], stroke);
        let spot = [x + 9.0 * out[0], y + 9.0 * out[1] + 4.3 + 4.0 * out[1]];
        // Two axes meet in a corner, where the second one's label gives way.
        if others.iter().any(|t| (t[0] - spot[0]).abs() < 28.0 && (t[1] - spot[1]).abs() < 14.0) {
            continue;
        }
        taken.push(spot);
        scene.text(Text { anchor, ..Text::new(spot, name, SMALL) });
    }
    let widest = widest(ticks);
    let middle = [0.5 * (start[0] + end[0]), 0.5 * (start[1] + end[1])];
    let (distance, upward) = if axis == 2 { (widest + 18.0, true) } else { (30.0, false) };
    let spot = [
        middle[0] + distance * out[0],
        middle[1] + distance * out[1] + if upward { 0.0 } else { 6.0 },
    ];
    let shift = if upward || anchor == Anchor::Middle { 0.0 } else { 0.5 * widest * out[0] };
    let text = Text::new([spot[0] + shift, spot[1]], label, NORMAL);
    scene.text(Text { upward, anchor: if upward { Anchor::Middle } else { anchor }, ..text });
}
