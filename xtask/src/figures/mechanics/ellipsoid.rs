//! Figure 2.9: the ellipsoid beside the exact surface of the uniform square.

use anyhow::Result;
use mechanics::{Ellipsoid, LimitSurface, Patch};
use planar::{Shape, Twist, Wrench};
use report::{Color, Figure, Line, Panel, Space, Surface, Table};

use super::rays::Rays;
use crate::figures::claims::judged;
use crate::figures::inputs::Inputs;
use crate::figures::sketch::Sketch;

/// Side of the thesis' square, in m.
const SIDE: f64 = 0.09;

pub(crate) fn draw(_: &Inputs) -> Result<Sketch> {
    let square = Shape::square(SIDE)?;
    let ellipsoid = Ellipsoid::uniform(&square, 1.0)?;
    let exact = Patch::uniform(&square, 1.0)?;
    let rays = Rays::shoot(&ellipsoid)?;
    let millis = |point: &[f64; 3]| [point[0], point[1], 1e3 * point[2]];
    let points: Vec<_> = rays.points.iter().map(millis).collect();
    let space = Space::new("Fx / N", "Fy / N", "M / (mN·m)")
        .title("ellipsoid")
        .with(Surface::facets(&points, &rays.facets));
    let (inner, outer) = (meridian(&ellipsoid)?, meridian(&exact)?);
    let panel = Panel::new("Fx / N", "M / (mN·m)")
        .title("section Fy = 0")
        .with(Line::new(&inner.0, &inner.1).color(Color::BLUE).label("ellipsoid"))
        .with(Line::new(&outer.0, &outer.1).color(Color::VERMILION).dashed().label("exact"));
    let table = Table::new()
        .column("fx_ellipsoid", &inner.0)
        .column("m_ellipsoid_mnm", &inner.1)
        .column("fx_exact", &outer.0)
        .column("m_exact_mnm", &outer.1);
    let figure = Figure::new(1, 2).panel_size(420.0, 360.0).with(space).with(panel);
    let caption = "The ellipsoid through the largest force and moment of a uniformly loaded 90 mm \
                   square that bears 1 N, and the square's exact surface, which bulges beyond it.";
    let alt = "An ellipsoid, and a section in which the exact surface lies outside of an ellipse.";
    let c = exact.wrench(&Twist::new(0.0, 0.0, 1.0))?.torque / exact.f_max();
    let formula = SIDE * (2f64.sqrt() + (1.0 + 2f64.sqrt()).ln()) / 6.0;
    let value = format!(
        "{:.4} mm by quadrature-free integration, {:.4} mm by the formula",
        1e3 * c,
        1e3 * formula
    );
    let claim = "3. c of the uniform square is a(√2 + ln(1 + √2))/6 ≈ 0.3826 a";
    let holds = (c / formula - 1.0).abs() < 1e-9;
    let reason = "the exact surface's largest moment over its largest force";
    Ok(Sketch::new(figure, table, caption, alt).claim(judged(claim, value, holds, reason)))
}

/// (Fx, M) around the section Fy = 0, in N and mN·m.
fn meridian(surface: &dyn LimitSurface) -> Result<(Vec<f64>, Vec<f64>)> {
    let length = surface.characteristic_length();
    let mut section = (Vec::new(), Vec::new());
    for k in 0..=180 {
        let angle = std::f64::consts::TAU * f64::from(k) / 180.0;
        let ray = Wrench::new(angle.cos(), 0.0, length * angle.sin());
        let load = 1.0 / surface.level(&ray)? * ray;
        section.0.push(load.force.x);
        section.1.push(1e3 * load.torque);
    }
    Ok(section)
}
