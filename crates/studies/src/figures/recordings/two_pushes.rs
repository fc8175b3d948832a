//! Figure 4.3: two pushes as they were recorded, drawn in the world.

use anyhow::Result;
use dataset::StepRow;
use nalgebra::Vector2;
use planar::{Pose, Shape, perpendicular};
use report::{Axis, Color, ColorMap, Ellipse, Figure, LegendPlace, Line, Panel, Polygon, Table};

use super::choice::Choice;
use crate::figures::inputs::Inputs;
use crate::figures::sketch::Sketch;

/// Contact position and direction of the thesis' two pushes.
const WANTED: [(f64, f64); 2] = [(0.5, 0.0), (0.3, -1.047_197_551_196_597_6)];
/// Outlines drawn of each push.
const N_OUTLINES: usize = 5;
const MM: f64 = 1e3;

/// A push as it is drawn: the object's and the pusher's way, one moment a step.
struct Drawn {
    place: String,
    shape: Shape,
    moments: Vec<(Pose, Vector2<f64>)>,
}

pub(crate) fn draw(inputs: &Inputs) -> Result<Sketch> {
    let report = inputs.ingest_report()?;
    let table = inputs.table()?;
    let radius = inputs.pusher()?.radius;
    let mut pushes = Vec::new();
    let mut columns: [Vec<f64>; 6] = Default::default();
    for (number, wanted) in WANTED.into_iter().enumerate() {
        let choice = Choice::nearest(report, wanted, |choice| choice.rows(table).len() > 1);
        let choice = choice.ok_or_else(|| inputs.lacking("pushes of two steps or more"))?;
        let rows = choice.rows(table);
        let shape = inputs.object(&choice.recording.name)?.shape;
        pushes.push(Drawn { place: choice.place(), shape, moments: moments(&rows) });
        for row in rows {
            let (pose, pusher) = (row.object_pose.position, row.pusher_start);
            let values = [number as f64, row.since_contact, pusher.x, pusher.y, pose.x, pose.y];
            columns.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
        }
    }
    let reach = pushes.iter().map(Drawn::reach).fold(0.0, f64::max);
    let mut figure = Figure::new(1, 2).panel_size(400.0, 400.0);
    for push in &pushes {
        figure = figure.with(push.panel(radius, reach).title(&push.place));
    }
    let names = ["push", "since_contact_s", "pusher_x_m", "pusher_y_m", "object_x_m", "object_y_m"];
    let numbers =
        names.iter().zip(&columns).fold(Table::new(), |table, (name, c)| table.column(name, c));
    let caption = "Two recorded pushes in the world frame, from dark to light as time passes: the \
                   outline of the object from its tracked poses, and the pusher (discs) on its \
                   straight path. The pushes are those of the data nearest to p = 0.5, β = 0° and \
                   to p = 0.3, β = −60°.";
    let alt = "Outlines of an object that is carried along and turned by a small disc.";
    Ok(Sketch::new(figure, numbers, caption, alt))
}

impl Drawn {
    /// The middle of the object's way, in m.
    fn middle(&self) -> Vector2<f64> {
        let (first, last) = (self.moments[0].0, self.moments[self.moments.len() - 1].0);
        0.5 * (first.position + last.position)
    }

    /// From the middle to the farthest that is drawn, along x or y, in m.
    fn reach(&self) -> f64 {
        let outline = self.shape.outline(120);
        let corners = self
            .moments
            .iter()
            .flat_map(|(pose, _)| outline.iter().map(move |corner| pose.transform_point(corner)));
        let points = corners.chain(self.moments.iter().map(|(_, center)| *center));
        points.map(|point| (point - self.middle()).amax()).fold(0.0, f64::max)
    }

    fn panel(&self, radius: f64, reach: f64) -> Panel {
        let axis = |label, middle: f64| {
            Axis::new(label).range(MM * (middle - 1.1 * reach), MM * (middle + 1.1 * reach))
        };
        let middle = self.middle();
        let mut panel = Panel::new(axis("world x / mm", middle.x), axis("world y / mm", middle.y))
            .equal_aspect()
            .legend(LegendPlace::Below);
        let last = self.moments.len() - 1;
        let n = N_OUTLINES.min(self.moments.len());
        let shown = |k: usize| self.moments[k * last / (n - 1)];
        for k in 0..n {
            let corners: Vec<[f64; 2]> = self
                .shape
                .outline(120)
                .iter()
                .map(|corner| (MM * shown(k).0.transform_point(corner)).into())
                .collect();
            let outline = Polygon::new(&corners).color(shade(k, n)).width(1.8);
            panel = panel.with(match k {
                0 => outline.label("first contact"),
                _ if k == n - 1 => outline.label("end of contact"),
                _ => outline,
            });
        }
        let path: Vec<[f64; 2]> =
            self.moments.iter().map(|(_, center)| (MM * center).into()).collect();
        let path = Line::through(&path).color(Color::VERMILION).width(1.4);
        panel = panel.with(path.label("pusher's center"));
        let disc = |k: usize| Ellipse::circle((MM * shown(k).1).into(), MM * radius);
        panel.with_all((0..n).map(|k| disc(k).color(shade(k, n)).fill(shade(k, n), 0.5)))
    }
}

/// Poses of the object and places of the pusher at the start of each step and the end of the last.
fn moments(rows: &[&StepRow]) -> Vec<(Pose, Vector2<f64>)> {
    let starts = rows.iter().map(|row| (row.object_pose, row.pusher_start));
    starts.chain(rows.last().map(|last| (end_pose(last), last.pusher_end))).collect()
}

/// Dark for the first of `n`, light (but visible on white) for the last.
fn shade(k: usize, n: usize) -> Color {
    ColorMap::Viridis.at(0.8 * k as f64 / (n - 1) as f64)
}

/// The object's pose at the end of a step in contact.
fn end_pose(row: &StepRow) -> Pose {
    let along = row.pusher_velocity.normalize();
    let moved = row.dx * along + row.dy * perpendicular(&along);
    let position = row.object_pose.position + moved;
    Pose { position, angle: row.object_pose.angle + row.dtheta }
}
