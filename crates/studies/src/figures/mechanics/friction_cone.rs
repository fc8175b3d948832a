//! Figure 2.1: the friction cone in two and three dimensions.

use std::f64::consts::TAU;

use anyhow::Result;
use mechanics::FrictionCone;
use nalgebra::{Vector2, Vector3};
use report::{
    Anchor, Arrows, Axis, Color, Curve, Figure, Guide, Note, Panel, Points, Polygon, Space,
    SpatialArrows, Surface,
};
use serde_json::json;

use crate::figures::inputs::Inputs;
use crate::figures::sketch::Sketch;

/// Coefficient of friction of the particle on its support.
const FRICTION: f64 = 0.5;
/// Normal force drawn, in N.
const NORMAL_FORCE: f64 = 1.0;
/// A force within the cone, and one that the contact cannot pass, in N.
const INSIDE: Vector3<f64> = Vector3::new(0.12, -0.25, 0.9);
const OUTSIDE: Vector3<f64> = Vector3::new(0.75, 0.55, 0.75);

pub(crate) fn draw(_: &Inputs) -> Result<Sketch> {
    let flat = FrictionCone::new(Vector2::y_axis(), FRICTION)?;
    let round = FrictionCone::new(Vector3::z_axis(), FRICTION)?;
    let nearest = round.project(&OUTSIDE);
    let [left, right] = flat.edges();
    let data = json!({
        "friction": FRICTION,
        "half_angle_deg": flat.half_angle().to_degrees(),
        "edges": [left.as_slice(), right.as_slice()],
        "inside_n": INSIDE.as_slice(),
        "outside_n": OUTSIDE.as_slice(),
        "nearest_in_cone_n": nearest.as_slice(),
        "contained": [round.contains(&INSIDE), round.contains(&OUTSIDE)],
    });
    let figure = Figure::new(1, 2)
        .panel_size(400.0, 330.0)
        .one_legend()
        .with(plane(&flat))
        .with(space(&round));
    let caption = format!(
        "(a) A particle that slides to the right: the normal force fₙ and the friction μ fₙ, which \
         opposes the slip, add up to a force on the edge of the cone. For μ = {FRICTION} the edge is \
         α = atan μ = {:.2}° from the normal. (b) The same in space: a force within the cone leaves \
         the particle at rest; one outside, {:.1}° from the normal, cannot be passed, and the nearest \
         force that can is {:.2} N away, on the surface.",
        flat.half_angle().to_degrees(),
        OUTSIDE.angle(&Vector3::z()).to_degrees(),
        (OUTSIDE - nearest).norm()
    );
    let alt = "A triangle that opens upward from a particle with the forces on it, and a cone in \
               space with one force inside and one outside.";
    Ok(Sketch::new(figure, data, &caption, alt))
}

fn plane(cone: &FrictionCone<2>) -> Panel {
    let [left, right] = cone.edges().map(|edge| (1.15 / edge.y) * edge.into_inner());
    let friction = FRICTION * NORMAL_FORCE;
    let arrow = |x: f64, y: f64| Arrows::new(&[[0.0, 0.0]], &[[x, y]]).width(2.2);
    let arc: Vec<_> = (0..=12)
        .map(|k| cone.half_angle() * f64::from(k) / 12.0)
        .map(|angle| [0.45 * angle.sin(), 0.45 * angle.cos()])
        .collect();
    let note = |x: f64, y: f64, text: &str| Note::new([x, y], text).offset(0.0, 0.0);
    Panel::new(
        Axis::new("force along the support / N").range(-0.85, 0.85),
        Axis::new("force along the normal / N").range(-0.2, 1.3),
    )
    .title("in the plane")
    .equal_aspect()
    .with(
        Polygon::new(&[[0.0, 0.0], [left.x, left.y], [right.x, right.y]])
            .color(Color::SKY)
            .fill(Color::SKY, 0.25),
    )
    .with(Guide::horizontal(0.0).color(Color::INK).width(2.0))
    .with(report::Line::through(&arc).color(Color::GRAY).width(1.2))
    .with(note(0.0, 1.2, "friction cone").anchor(Anchor::Middle))
    .with(note(0.09, 0.5, "α"))
    .with(arrow(0.0, NORMAL_FORCE).color(Color::GREEN))
    .with(note(0.03, 0.86, "fₙ"))
    .with(arrow(-friction, 0.0).color(Color::VERMILION))
    .with(note(-0.42, -0.12, "μ fₙ").anchor(Anchor::Middle))
    .with(arrow(-friction, NORMAL_FORCE).color(Color::BLUE))
    .with(note(-0.55, 0.94, "f").anchor(Anchor::End))
    .with(arrow(0.5, 0.0).color(Color::INK))
    .with(note(0.42, -0.12, "slip").anchor(Anchor::Middle))
    .with(Points::at(&[[0.0, 0.0]]).color(Color::INK).radius(4.5))
}

fn space(cone: &FrictionCone<3>) -> Space {
    let height = 1.15;
    let on = move |t: f64, angle: f64| {
        let ring = t * height * FRICTION;
        [ring * angle.cos(), ring * angle.sin(), t * height]
    };
    let rim: Vec<_> = (0..=72).map(|k| on(1.0, TAU * f64::from(k) / 72.0)).collect();
    let nearest = cone.project(&OUTSIDE);
    let force = |tip: Vector3<f64>| SpatialArrows::new(&[[0.0; 3]], &[tip.into()]).width(2.2);
    let axis = |label: &str, low: f64, high: f64| Axis::new(label).range(low, high);
    Space::new(axis("fx / N", -0.8, 0.8), axis("fy / N", -0.8, 0.8), axis("fₙ / N", 0.0, 1.25))
        .title("in space")
        .equal_aspect()
        .view(-0.9, 0.3)
        .with(Surface::parametric(48, 1, |s, t| on(t, TAU * s)).opacity(0.45))
        .with(Curve::new(&rim).color(Color::BLUE).width(1.4))
        .with(force(INSIDE).color(Color::GREEN).label("passed at rest"))
        .with(force(OUTSIDE).color(Color::VERMILION).label("cannot be passed"))
        .with(
            Curve::new(&[OUTSIDE.into(), nearest.into()])
                .color(Color::VERMILION)
                .width(1.4)
                .dashed(),
        )
        .with(force(nearest).color(Color::INK).label("nearest that can"))
}
