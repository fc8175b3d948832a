//! Figure 2.5: the limit curve of Coulomb friction, and an anisotropic one.

use std::f64::consts::TAU;

use anyhow::Result;
use nalgebra::Vector2;
use report::{Arrows, Axis, Color, Figure, Guide, Line, Panel, Points, Table};

use crate::figures::inputs::Inputs;
use crate::figures::sketch::Sketch;

/// Largest friction force along the axes, in N: isotropic, and half as large along y.
const CURVES: [(&str, [f64; 2]); 2] =
    [("Coulomb friction", [1.0, 1.0]), ("anisotropic friction", [1.0, 0.5])];

pub(crate) fn draw(_: &Inputs) -> Result<Sketch> {
    let mut figure = Figure::new(1, 2).panel_size(400.0, 380.0).one_legend();
    let mut table = Table::new();
    let axis = |label: &str| Axis::new(label).range(-1.5, 1.5);
    for (index, (title, axes)) in CURVES.into_iter().enumerate() {
        let angles: Vec<f64> = (0..=180).map(|k| TAU * f64::from(k) / 180.0).collect();
        let forces: Vec<_> = angles.iter().map(|&angle| force(axes, angle)).collect();
        let marked: Vec<_> = marked(axes).collect();
        let velocities: Vec<_> = marked.iter().map(|f| velocity(axes, f)).collect();
        figure = figure.with(
            Panel::new(axis("fx / N"), axis("fy / N"))
                .title(title)
                .equal_aspect()
                .with(Guide::horizontal(0.0))
                .with(Guide::vertical(0.0))
                .with(Line::through(&forces).color(Color::BLUE).width(2.0).label("limit curve"))
                .with(Arrows::new(&marked, &velocities).scale(0.35).label("slip velocity"))
                .with(
                    Points::at(&marked)
                        .color(Color::VERMILION)
                        .label("friction force on the support"),
                ),
        );
        let column = |k: usize, of: &[[f64; 2]]| of.iter().map(|v| v[k]).collect::<Vec<_>>();
        for (name, k) in [("x", 0), ("y", 1)] {
            table = table
                .column(&format!("f{name}_{index}"), &column(k, &marked))
                .column(&format!("v{name}_{index}"), &column(k, &velocities));
        }
    }
    let caption = format!(
        "Forces that a sliding support point can bear, and the direction in which it \
                   slips under each: the outward normal. For Coulomb friction the force is along \
                   the slip; where friction depends on direction it is not, by up to {:.1}° at the \
         forces drawn.",
        largest_angle(&CURVES[1].1)
    );
    let alt = "A circle and an ellipse in the plane of forces, with arrows along their normals.";
    Ok(Sketch::new(figure, table, &caption, alt))
}

fn force(axes: [f64; 2], angle: f64) -> [f64; 2] {
    [axes[0] * angle.cos(), axes[1] * angle.sin()]
}

/// The forces at which slip velocities are drawn.
fn marked(axes: [f64; 2]) -> impl Iterator<Item = [f64; 2]> {
    (0..12).map(move |k| force(axes, TAU * (f64::from(k) + 0.5) / 12.0))
}

/// The largest angle between a marked force and its slip, in degrees.
fn largest_angle(axes: &[f64; 2]) -> f64 {
    let between = |f: [f64; 2]| Vector2::from(f).angle(&Vector2::from(velocity(*axes, &f)));
    marked(*axes).map(between).fold(0.0, f64::max).to_degrees()
}

/// Unit normal of the curve (fx/a)² + (fy/b)² = 1.
fn velocity(axes: [f64; 2], force: &[f64; 2]) -> [f64; 2] {
    let normal = [force[0] / axes[0].powi(2), force[1] / axes[1].powi(2)];
    let length = normal[0].hypot(normal[1]);
    normal.map(|n| n / length)
}
