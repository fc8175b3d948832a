//! Figure 2.11: the analytical push over contact position and direction.

use anyhow::Result;
use mechanics::{Ellipsoid, PathSettings, Slider, StraightPath, push_along};
use nalgebra::Vector2;
use planar::{Pose, Shape};
use report::{ColorMap, Figure, Grid, HeatMap, Panel, Table};

use super::top_view::{PUSHER, SIDE, SPEED};
use crate::figures::inputs::Inputs;
use crate::figures::sketch::Sketch;

/// The thesis' time step, in s.
const DURATION: f64 = 0.2;

const COLUMNS: usize = 61;
const ROWS: usize = 41;
const P_RANGE: (f64, f64) = (0.0, 1.0);
const BETA_RANGE: (f64, f64) = (-1.0, 1.0);

pub(crate) fn draw(_: &Inputs) -> Result<Sketch> {
    let shape = Shape::square(SIDE)?;
    let surface = Ellipsoid::uniform(&shape, 1.0)?;
    let slider = Slider { shape: &shape, surface: &surface, pose_bs: Pose::default() };
    let at = |k: usize, n: usize, range: (f64, f64)| {
        range.0 + (range.1 - range.0) * k as f64 / (n - 1) as f64
    };
    let mut columns: [Vec<f64>; 5] = Default::default();
    for row in 0..ROWS {
        for column in 0..COLUMNS {
            let (p, beta) = (at(column, COLUMNS, P_RANGE), at(row, ROWS, BETA_RANGE));
            let [dx, dy, dtheta] = step(&slider, p, beta)?;
            let values = [p, beta, 1e3 * dx, 1e3 * dy, dtheta.to_degrees()];
            columns.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
        }
    }
    let [p, beta, dx, dy, dtheta] = columns;
    let table = Table::new()
        .column("p", &p)
        .column("beta_rad", &beta)
        .column("dx_mm", &dx)
        .column("dy_mm", &dy)
        .column("dtheta_deg", &dtheta);
    let panels = [
        ("Δx, along the push", "Δx / mm", dx, ColorMap::Viridis),
        ("Δy, to the left of the push", "Δy / mm", dy, ColorMap::Diverging),
        ("Δθ, counter-clockwise", "Δθ / °", dtheta, ColorMap::Diverging),
    ];
    let mut figure = Figure::new(1, 3);
    for (title, label, values, map) in panels {
        let grid = Grid::new(P_RANGE, BETA_RANGE, COLUMNS, ROWS, values);
        figure = figure.with(
            Panel::new("contact position p", "push direction β / rad")
                .title(title)
                .with(HeatMap::new(grid, label).map(map)),
        );
    }
    let caption = "Motion of the 90 mm square in one step of 0.2 s at 20 mm/s by the ellipsoidal \
                   limit surface (μp 0.25): Δy depends mainly on the direction, Δθ mainly on the \
                   contact position. Counter-clockwise turns and directions are positive.";
    let alt = "Three maps over contact position and push direction.";
    Ok(Sketch::new(figure, table, caption, alt))
}

/// (Δx, Δy, Δθ) of a step on the edge at −x, whose p runs along −y, in the pusher's direction.
fn step(slider: &Slider, p: f64, beta: f64) -> Result<[f64; 3]> {
    let direction = Vector2::new(beta.cos(), beta.sin());
    let start_w = Vector2::new(-0.5 * SIDE - PUSHER.radius, SIDE * (0.5 - p));
    let path = StraightPath { start_w, velocity_w: SPEED * direction, duration: DURATION };
    let end = push_along(slider, &PUSHER, &path, &Pose::default(), &PathSettings::default())?;
    let moved = end.pose_wb.position;
    Ok([moved.dot(&direction), planar::cross(&direction, &moved), end.pose_wb.angle])
}
