//! Figure 2.8: the limit surfaces of two and three support points, with their facets.

use std::f64::consts::{PI, TAU};

use anyhow::Result;
use mechanics::{Facet, PointSet};
use nalgebra::Vector2;
use planar::Wrench;
use report::{Axis, Color, Curve, Figure, Space, Surface, Table};

use super::rays::Rays;
use crate::figures::inputs::Inputs;
use crate::figures::sketch::Sketch;

/// Distance of every support point from the origin, in m.
const DISTANCE: f64 = 0.5;

pub(crate) fn draw(_: &Inputs) -> Result<Sketch> {
    let mut figure = Figure::new(1, 2).panel_size(420.0, 325.0);
    let mut table = Table::new();
    let axis = |label: &str, reach: f64| Axis::new(label).range(-reach, reach);
    for (n, title) in [(2, "two points"), (3, "three points")] {
        let at = |k: u32| {
            let angle = TAU * f64::from(k) / f64::from(n) + 0.5 * PI;
            DISTANCE * Vector2::new(angle.cos(), angle.sin())
        };
        let surface = PointSet::new((0..n).map(|k| (at(k), 1.0 / f64::from(n))))?;
        let rays = Rays::shoot(&surface)?;
        for (k, name) in ["fx", "fy", "m"].into_iter().enumerate() {
            table = table.column(&format!("{name}_{n}_points"), &rays.column(k));
        }
        let body = Surface::facets(&rays.points, &rays.facets).convex();
        let mut space =
            Space::new(axis("Fx / N", 1.3), axis("Fy / N", 1.3), axis("M / (N·m)", 0.6))
                .title(title)
                .with(body);
        for facet in surface.facets() {
            space = space.with(Curve::new(&rim(&facet)).color(Color::VERMILION).width(1.4));
        }
        figure = figure.with(space);
    }
    let caption = "Support points that share the load equally, 0.5 m from the origin. Each leaves a \
                   flat facet (outlined) on either side: turning about a point leaves that point's \
                   own friction undecided.";
    let alt = "Two bodies in the space of forces and moments with two and three flat discs above \
               and below.";
    Ok(Sketch::new(figure, table, caption, alt))
}

fn rim(facet: &Facet) -> Vec<[f64; 3]> {
    let on_rim = |k: i32| {
        let angle = TAU * f64::from(k) / 60.0;
        let force = facet.radius * Vector2::new(angle.cos(), angle.sin());
        let load = facet.center + Wrench::from_force_at(&force, &facet.at);
        [load.force.x, load.force.y, load.torque]
    };
    (0..=60).map(on_rim).collect()
}
