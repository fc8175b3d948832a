//! Figure 2.9: the ellipsoid beside the exact surface of the uniform square.

use anyhow::Result;
use mechanics::{Ellipsoid, LimitSurface, Patch};
use planar::{Shape, Twist, Wrench, mit_object};
use report::{Axis, Claim, Color, Figure, Line, Panel, Space, Surface};
use serde_json::json;

use super::rays::Rays;
use super::top_view::SIDE;
use crate::figures::claims::judged;
use crate::figures::inputs::Inputs;
use crate::figures::sketch::Sketch;

/// What this figure settles.
pub(crate) const CLAIMS: [&str; 1] =
    ["3. c of the uniform square is a(√2 + ln(1 + √2))/6 ≈ 0.3826 a"];

pub(crate) fn draw(_: &Inputs) -> Result<Sketch> {
    let square = Shape::square(SIDE)?;
    let ellipsoid = Ellipsoid::uniform(&square, 1.0)?;
    let exact = Patch::uniform(&square, 1.0)?;
    let (round, true_shape) = (Rays::shoot(&ellipsoid)?, Rays::shoot(&exact)?);
    let (inner, outer) = (section(&exact)?, section(&ellipsoid)?);
    let panel = Panel::new("Fx / Fmax", "M / Mmax")
        .title("section Fy = 0")
        .equal_aspect()
        .with(Line::through(&outer).color(Color::BLUE).label("ellipsoid"))
        .with(Line::through(&inner).color(Color::VERMILION).dashed().label("exact surface"));
    let figure = Figure::new(1, 3)
        .panel_size(350.0, 310.0)
        .one_legend()
        .with(space("ellipsoid", &round, Color::BLUE))
        .with(space("exact surface", &true_shape, Color::VERMILION))
        .with(panel);
    let reach = Reach::of(&ellipsoid, &true_shape)?;
    let data = json!({
        "ellipsoid": in_millis(&round),
        "exact": in_millis(&true_shape),
        "section_ellipsoid": outer,
        "section_exact": inner,
        "smallest_level_of_exact_loads": reach.least,
        "largest_level_of_exact_loads": reach.most,
    });
    let caption = format!(
        "Uniformly loaded square of {:.0} mm that bears 1 N. The ellipsoid goes through its largest \
         force and largest moment, where both surfaces touch; the loads of the exact surface reach \
         {:.1} to {:.1} % of the way to the ellipsoid ({} loads). Where the center of friction is not that of torsion it must also tilt: turned \
         about its centroid, the triangle tri1 keeps a net force of {:.1} % of Fmax.",
        1e3 * SIDE,
        100.0 * reach.least,
        100.0 * reach.most,
        true_shape.points.len(),
        100.0 * leftover_force("tri1")?,
    );
    let alt = "An ellipsoid, the exact surface with the same extremes, and a section through both.";
    Ok(Sketch::new(figure, data, &caption, alt).claim(characteristic_length(&exact)?))
}

/// Loads in N, N and mN·m.
fn in_millis(rays: &Rays) -> Vec<[f64; 3]> {
    rays.points.iter().map(|[fx, fy, m]| [*fx, *fy, 1e3 * m]).collect()
}

fn space(title: &str, rays: &Rays, color: Color) -> Space {
    let axis = |label: &str, reach: f64| Axis::new(label).range(-reach, reach);
    Space::new(axis("Fx / N", 1.3), axis("Fy / N", 1.3), axis("M / (mN·m)", 40.0))
        .title(title)
        .with(Surface::facets(&in_millis(rays), &rays.facets).color(color).convex())
}

/// How far the exact surface's loads reach toward the ellipsoid: 1 is on it.
struct Reach {
    least: f64,
    most: f64,
}

impl Reach {
    fn of(ellipsoid: &Ellipsoid, exact: &Rays) -> Result<Self> {
        let mut reach = Self { least: f64::INFINITY, most: 0.0 };
        for &[fx, fy, m] in &exact.points {
            let level = ellipsoid.level(&Wrench::new(fx, fy, m))?;
            reach = Self { least: reach.least.min(level), most: reach.most.max(level) };
        }
        anyhow::ensure!(reach.most < 1.0 + 1e-9, "the exact surface leaves the ellipsoid");
        Ok(reach)
    }
}

/// (Fx/Fmax, M/Mmax) around the section Fy = 0.
fn section(surface: &dyn LimitSurface) -> Result<Vec<[f64; 2]>> {
    let (f_max, length) = (1.0, surface.characteristic_length());
    let mut section = Vec::new();
    for k in 0..=180 {
        let angle = std::f64::consts::TAU * f64::from(k) / 180.0;
        let ray = Wrench::new(angle.cos(), 0.0, length * angle.sin());
        let load = 1.0 / surface.level(&ray)? * ray;
        section.push([load.force.x / f_max, load.torque / (length * f_max)]);
    }
    Ok(section)
}

/// Net force of friction, over its largest, while a shape turns about its centroid.
fn leftover_force(name: &str) -> Result<f64> {
    let shape = mit_object(name)?.shape;
    let about = shape.centroid();
    let turn = Twist::new(0.0, 0.0, 1.0).shifted(&-about);
    Ok(Patch::uniform(&shape, 1.0)?.wrench(&turn)?.force.norm())
}

fn characteristic_length(exact: &Patch) -> Result<Claim> {
    let c = exact.wrench(&Twist::new(0.0, 0.0, 1.0))?.torque / exact.f_max();
    let share = (2f64.sqrt() + (1.0 + 2f64.sqrt()).ln()) / 6.0;
    let value = format!(
        "{:.4} mm = {:.4} a for a = {:.0} mm; by the formula {:.4} mm",
        1e3 * c,
        c / SIDE,
        1e3 * SIDE,
        1e3 * share * SIDE
    );
    let holds = (c / (share * SIDE) - 1.0).abs() < 1e-9;
    let reason = "moment of friction while the square turns about its center, over its largest \
                  force; equal to a relative 1e-9";
    Ok(judged(CLAIMS[0], value, holds, reason))
}
