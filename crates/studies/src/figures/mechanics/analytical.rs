//! Figure 2.11: the analytical push over contact position and direction.

use anyhow::Result;
use mechanics::{Ellipsoid, PathSettings, Slider, StraightPath, push_along};
use nalgebra::Vector2;
use planar::{Pose, Shape};
use report::{Claim, Color, ColorMap, Contours, Figure, Grid, HeatMap, Panel, Table};

use super::top_view::{PUSHER, SIDE, SPEED};
use crate::figures::claims::judged;
use crate::figures::inputs::Inputs;
use crate::figures::sketch::Sketch;

/// The thesis' time step, in s.
const DURATION: f64 = 0.2;

const COLUMNS: usize = 80;
const ROWS: usize = 64;
const P_RANGE: (f64, f64) = (0.0, 1.0);
const BETA_RANGE: (f64, f64) = (-1.0, 1.0);

/// A map's title, the label of its color bar, its color map and its contour lines.
type Map = (&'static str, &'static str, ColorMap, &'static [f64]);

const MAPS: [Map; 3] = [
    ("Δx, along the push", "Δx / mm", ColorMap::Viridis, &[1.0, 2.0, 3.0, 3.9]),
    ("Δy, to the left of the push", "Δy / mm", ColorMap::Diverging, &[-1.0, -0.5, 0.0, 0.5, 1.0]),
    ("Δθ, counter-clockwise", "Δθ / °", ColorMap::Diverging, &[-2.0, -1.0, 0.0, 1.0, 2.0]),
];

/// What this figure settles.
pub(crate) const CLAIMS: [&str; 1] = [
    "15. In the analytical model β > 0 gives Δy < 0 (positive to the left of the push); Δy depends \
     mainly on β, Δθ mainly on p",
];

pub(crate) fn draw(_: &Inputs) -> Result<Sketch> {
    let steps = steps()?;
    let column = |k: usize| steps.iter().map(|step| step[k]).collect::<Vec<f64>>();
    let names = ["p", "beta_rad", "dx_mm", "dy_mm", "dtheta_deg"];
    let table = (0..5).fold(Table::new(), |table, k| table.column(names[k], &column(k)));
    let mut figure = Figure::new(1, 3).panel_size(375.0, 310.0);
    for (k, (title, label, map, levels)) in MAPS.into_iter().enumerate() {
        let grid = Grid::new(P_RANGE, BETA_RANGE, COLUMNS, ROWS, column(k + 2));
        let line = if map == ColorMap::Viridis { Color::WHITE } else { Color::INK };
        figure = figure.with(
            Panel::new("contact position p", "push direction β / rad")
                .title(title)
                .with(HeatMap::new(grid.clone(), label).map(map))
                .with(Contours::new(grid, levels).color(line).width(0.9)),
        );
    }
    let [dy, dtheta] = [column(3), column(4)].map(|values| main_effects(&values));
    let caption = format!(
        "Motion of the 90 mm square in one step of {DURATION} s at 20 mm/s by the ellipsoidal limit \
         surface (μp = {}), Δx at most {:.2} mm. Direction β and turn are positive counter-clockwise; \
         p runs to the right as seen along the inward normal. Contour lines: Δx {} mm, \
         Δy {} mm, Δθ {}°. Of the variance of Δy \
         over this map {:.0} % is due to β alone and {:.0} % to p alone, of that of Δθ {:.0} % and \
         {:.0} %; the rest is their interaction.",
        PUSHER.friction,
        column(2).into_iter().fold(f64::NEG_INFINITY, f64::max),
        list(MAPS[0].3),
        list(MAPS[1].3),
        list(MAPS[2].3),
        100.0 * dy.beta,
        100.0 * dy.p,
        100.0 * dtheta.beta,
        100.0 * dtheta.p,
    );
    let alt = "Three maps over contact position and push direction: the first is highest in the \
               middle, the second changes from top to bottom, the third from left to right.";
    let claim = dependence(&steps, &dy, &dtheta);
    Ok(Sketch::new(figure, table, &caption, alt).claim(claim))
}

fn list(levels: &[f64]) -> String {
    levels.iter().map(f64::to_string).collect::<Vec<_>>().join(", ")
}

/// (p, β in rad, Δx and Δy in mm, Δθ in °) at the cells' centers, rounded to 1 nm and 1e-6°.
fn steps() -> Result<Vec<[f64; 5]>> {
    let shape = Shape::square(SIDE)?;
    let surface = Ellipsoid::uniform(&shape, 1.0)?;
    let slider = Slider { shape: &shape, surface: &surface, pose_bs: Pose::default() };
    let at = |k: usize, n: usize, (low, high): (f64, f64)| {
        low + (high - low) * (k as f64 + 0.5) / n as f64
    };
    let round = |value: f64| (1e6 * value).round() / 1e6;
    let mut steps = Vec::with_capacity(ROWS * COLUMNS);
    for row in 0..ROWS {
        for column in 0..COLUMNS {
            let (p, beta) = (at(column, COLUMNS, P_RANGE), at(row, ROWS, BETA_RANGE));
            let [dx, dy, dtheta] = step(&slider, p, beta)?;
            steps.push([p, beta, round(1e3 * dx), round(1e3 * dy), round(dtheta.to_degrees())]);
        }
    }
    Ok(steps)
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

/// Shares of a map's variance that the mean over the other input explains.
struct MainEffects {
    p: f64,
    beta: f64,
}

fn main_effects(values: &[f64]) -> MainEffects {
    let mean = |values: &mut dyn Iterator<Item = f64>| {
        let (sum, n) = values.fold((0.0, 0.0), |(sum, n), value| (sum + value, n + 1.0));
        sum / n
    };
    let variance = |values: &[f64]| {
        let center = mean(&mut values.iter().copied());
        mean(&mut values.iter().map(|value| (value - center).powi(2)))
    };
    let by_row: Vec<f64> =
        values.chunks(COLUMNS).map(|row| mean(&mut row.iter().copied())).collect();
    let by_column: Vec<f64> = (0..COLUMNS)
        .map(|column| mean(&mut values.iter().skip(column).step_by(COLUMNS).copied()))
        .collect();
    let whole = variance(values);
    MainEffects { p: variance(&by_column) / whole, beta: variance(&by_row) / whole }
}

fn dependence(steps: &[[f64; 5]], dy: &MainEffects, dtheta: &MainEffects) -> Claim {
    let turned = steps.iter().filter(|step| step[1] > 0.0);
    let negative = turned.clone().filter(|step| step[3] < 0.0).count() as f64;
    let share = negative / turned.count() as f64;
    let value = format!(
        "Δy < 0 on {:.1} % of the map at β > 0; β explains {:.0} % of Δy, p {:.0} %; p explains \
         {:.0} % of Δθ, β {:.0} %",
        100.0 * share,
        100.0 * dy.beta,
        100.0 * dy.p,
        100.0 * dtheta.p,
        100.0 * dtheta.beta
    );
    let holds = share > 0.5 && dy.beta > 0.5 && dtheta.p > 0.5;
    let reason = "each share above one half; shares of variance over the map of figure 2.11";
    judged(CLAIMS[0], value, holds, reason)
}
