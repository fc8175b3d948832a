//! Figure 2.6: a limit surface of ellipsoidal, cylindrical and spherical parts.

use std::f64::consts::{FRAC_PI_2, TAU};

use anyhow::Result;
use report::{Color, Figure, LegendPlace, Space, SpatialArrows, Surface, Table};

use crate::figures::inputs::Inputs;
use crate::figures::sketch::Sketch;

/// Radius of sphere and cylinder, and half the cylinder's length; the ellipsoid is as high as this.
const RADIUS: f64 = 1.0;
const HALF_LENGTH: f64 = 0.5;
const CAP_HEIGHT: f64 = 1.6;

/// A part: heights of its end and its polar angles, and its color.
struct Part {
    name: &'static str,
    color: Color,
    point: fn(f64, f64) -> [f64; 3],
    normal: fn([f64; 3]) -> [f64; 3],
}

const PARTS: [Part; 3] = [
    Part { name: "ellipsoid", color: Color::BLUE, point: on_ellipsoid, normal: ellipsoid_normal },
    Part { name: "cylinder", color: Color::GREEN, point: on_cylinder, normal: cylinder_normal },
    Part { name: "sphere", color: Color::VERMILION, point: on_sphere, normal: sphere_normal },
];

pub(crate) fn draw(_: &Inputs) -> Result<Sketch> {
    let mut space = Space::new("Fx / N", "Fy / N", "M / (N·m)")
        .view(0.6, 0.3)
        .equal_aspect()
        .legend(LegendPlace::Below);
    let mut rows: Vec<[f64; 6]> = Vec::new();
    for part in &PARTS {
        let at: Vec<_> =
            (0..12).flat_map(|k| [0.3, 0.75].map(|t| (f64::from(k) / 12.0, t))).collect();
        let tails: Vec<_> = at.iter().map(|&(s, t)| (part.point)(s, t)).collect();
        let normals: Vec<_> =
            tails.iter().map(|&tail| (part.normal)(tail).map(|n| 0.5 * n)).collect();
        rows.extend(tails.iter().zip(&normals).map(|(f, q)| [f[0], f[1], f[2], q[0], q[1], q[2]]));
        space = space
            .with(
                Surface::parametric(48, 10, part.point)
                    .color(part.color)
                    .opacity(0.55)
                    .label(part.name),
            )
            .with(SpatialArrows::new(&tails, &normals).color(part.color));
    }
    let names = ["fx", "fy", "m", "qx", "qy", "qomega"];
    let column = |k: usize| rows.iter().map(|row| row[k]).collect::<Vec<_>>();
    let table = (0..6).fold(Table::new(), |table, k| table.column(names[k], &column(k)));
    let caption = "A smooth limit surface made of half an ellipsoid, a cylinder and half a sphere. \
                   The motion under a load is along the outward normal; on the cylinder a whole \
                   line of loads belongs to one motion. The shape is assembled to show this: a \
                   surface made by friction alone is also symmetric about the origin.";
    let alt = "A capsule in the space of forces and moments with arrows standing on it.";
    Ok(Sketch::new(Figure::new(1, 1).panel_size(560.0, 470.0).with(space), table, caption, alt))
}

fn on_ellipsoid(s: f64, t: f64) -> [f64; 3] {
    let (angle, polar) = (TAU * s, FRAC_PI_2 * t);
    let ring = RADIUS * polar.cos();
    [ring * angle.cos(), ring * angle.sin(), HALF_LENGTH + CAP_HEIGHT * polar.sin()]
}

fn on_cylinder(s: f64, t: f64) -> [f64; 3] {
    let angle = TAU * s;
    [RADIUS * angle.cos(), RADIUS * angle.sin(), HALF_LENGTH * (2.0 * t - 1.0)]
}

fn on_sphere(s: f64, t: f64) -> [f64; 3] {
    let (angle, polar) = (TAU * s, FRAC_PI_2 * t);
    let ring = RADIUS * polar.cos();
    [ring * angle.cos(), ring * angle.sin(), -HALF_LENGTH - RADIUS * polar.sin()]
}

fn ellipsoid_normal([x, y, z]: [f64; 3]) -> [f64; 3] {
    unit([x / RADIUS.powi(2), y / RADIUS.powi(2), (z - HALF_LENGTH) / CAP_HEIGHT.powi(2)])
}

fn cylinder_normal([x, y, _]: [f64; 3]) -> [f64; 3] {
    unit([x, y, 0.0])
}

fn sphere_normal([x, y, z]: [f64; 3]) -> [f64; 3] {
    unit([x, y, z + HALF_LENGTH])
}

fn unit(vector: [f64; 3]) -> [f64; 3] {
    let length = vector.iter().map(|v| v * v).sum::<f64>().sqrt();
    vector.map(|v| v / length)
}
