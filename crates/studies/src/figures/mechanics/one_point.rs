//! Figure 2.7: the limit surface of a single support point.

use std::f64::consts::TAU;

use anyhow::Result;
use nalgebra::Vector2;
use planar::Wrench;
use report::{Color, Curve, Figure, Space, Surface, Table};

use crate::figures::inputs::Inputs;
use crate::figures::sketch::Sketch;

/// Reach of the axis of moments, in N·m.
const MOMENT: f64 = 0.6;

const PLACES: [(&str, [f64; 2]); 2] =
    [("support point at the origin", [0.0, 0.0]), ("support point at (0, 0.5) m", [0.0, 0.5])];

pub(crate) fn draw(_: &Inputs) -> Result<Sketch> {
    let mut figure = Figure::new(1, 2).panel_size(400.0, 315.0).one_legend();
    let mut table = Table::new();
    for (index, (title, [x, y])) in PLACES.into_iter().enumerate() {
        // The point bears 1 N in any direction.
        let load = |angle: f64| {
            let force = Vector2::new(angle.cos(), angle.sin());
            let wrench = Wrench::from_force_at(&force, &Vector2::new(x, y));
            [wrench.force.x, wrench.force.y, wrench.torque]
        };
        let rim: Vec<_> = (0..=120).map(|k| load(TAU * f64::from(k) / 120.0)).collect();
        for (k, name) in ["fx", "fy", "m"].into_iter().enumerate() {
            let column: Vec<_> = rim.iter().map(|load| load[k]).collect();
            table = table.column(&format!("{name}_{index}"), &column);
        }
        let shadow: Vec<_> = rim.iter().map(|load| [load[0], load[1], -MOMENT]).collect();
        let axes = [("Fx / N", 1.3), ("Fy / N", 1.3), ("M / (N·m)", MOMENT)];
        let [fx, fy, m] = axes.map(|(label, reach)| report::Axis::new(label).range(-reach, reach));
        figure = figure.with(
            Space::new(fx, fy, m)
                .title(title)
                .with(
                    Curve::new(&shadow).color(Color::GRAY).width(1.4).dashed().label("limit curve"),
                )
                .with(Surface::facets(&rim, &[(0..rim.len()).collect()]).opacity(0.6))
                .with(Curve::new(&rim).color(Color::BLUE).label("limit surface")),
        );
    }
    let caption = "One support point bears a disc of forces, so its loads form a flat ellipse: \
                   level if the point is the origin, tilted along (−y, x) if it is not. Its \
                   projection on the plane of forces is the limit curve (dashed), a circle for both.";
    let alt = "Two flat discs in the space of forces and moments, the second one tilted.";
    Ok(Sketch::new(figure, table, caption, alt))
}
