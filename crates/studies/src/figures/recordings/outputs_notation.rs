//! Figure 4.6: the displacements Δx and Δy and the turn Δθ of a step.

use anyhow::Result;
use mechanics::{Ellipsoid, PathSettings, Pusher, Slider, StraightPath, push_along};
use nalgebra::Vector2;
use planar::{Pose, Shape, perpendicular};
use report::{
    Anchor, Arrows, Axis, Color, Ellipse, Figure, LegendPlace, Line, Note, Panel, Points, Polygon,
    Table,
};

use crate::figures::inputs::Inputs;
use crate::figures::sketch::Sketch;

/// The thesis' square and pusher: m, dimensionless.
const SIDE: f64 = 0.09;
const PUSHER: Pusher = Pusher { radius: 0.00475, friction: 0.25 };
/// A push that is long enough to be seen: edge, p, β in rad, way in m.
const EDGE: usize = 1;
const P: f64 = 0.35;
const BETA: f64 = 0.6;
const WAY: f64 = 0.04;
const MM: f64 = 1e3;

/// The object before and after, and the unit vector of the push.
struct Step {
    shape: Shape,
    start_w: Vector2<f64>,
    along: Vector2<f64>,
    after: Pose,
}

pub(crate) fn draw(_: &Inputs) -> Result<Sketch> {
    let step = step()?;
    let moved = step.after.position;
    let left = perpendicular(&step.along);
    let (dx, dy) = (moved.dot(&step.along), moved.dot(&left));
    let figure = Figure::new(1, 2)
        .panel_size(440.0, 400.0)
        .with(displacement(&step, dx, dy).title("displacement of the body's origin"))
        .with(turn(&step).title("turn of the body"));
    let table = Table::new()
        .column("p", &[P])
        .column("beta_rad", &[BETA])
        .column("way_m", &[WAY])
        .column("dx_m", &[dx])
        .column("dy_m", &[dy])
        .column("dtheta_rad", &[step.after.angle]);
    let caption = format!(
        "A computed push (p = {P}, β = {:.0}°, way {:.0} mm, ellipsoid). Δx is along the pusher's \
         velocity, Δy along its left normal: here {:.1} mm and {:.1} mm. Δθ is counter-clockwise \
         positive: here {:.1}°.",
        BETA.to_degrees(),
        WAY * MM,
        dx * MM,
        dy * MM,
        step.after.angle.to_degrees()
    )
    .replace('-', "\u{2212}");
    let alt = "A square before and after a push, with arrows for its displacement along and \
               across the push and an arc for its turn.";
    Ok(Sketch::new(figure, table, &caption, alt))
}

fn step() -> Result<Step> {
    let shape = Shape::square(SIDE)?;
    let surface = Ellipsoid::uniform(&shape, 1.0)?;
    let normal = shape.inward_normal_at(EDGE, P);
    let along = Pose::new(0.0, 0.0, BETA).rotate(&normal);
    let start_w = shape.point_at(EDGE, P) - PUSHER.radius * normal;
    let path = StraightPath { start_w, velocity_w: along, duration: WAY };
    let slider = Slider { shape: &shape, surface: &surface, pose_bs: Pose::default() };
    let motion = push_along(&slider, &PUSHER, &path, &Pose::default(), &PathSettings::default())?;
    Ok(Step { start_w, along, after: motion.pose_wb, shape })
}

fn displacement(step: &Step, dx: f64, dy: f64) -> Panel {
    let left = perpendicular(&step.along);
    let moved = step.after.position;
    let end_w = step.start_w + WAY * step.along;
    let corner = dx * step.along;
    let disc = |center: Vector2<f64>| {
        Ellipse::circle((MM * center).into(), MM * PUSHER.radius).color(Color::GRAY)
    };
    Panel::new(Axis::new("x / mm").range(-75.0, 105.0), Axis::new("y / mm").range(-70.0, 75.0))
        .equal_aspect()
        .legend(LegendPlace::Below)
        .with(outline(&step.shape, &Pose::default()).dashed().color(Color::GRAY).label("before"))
        .with(outline(&step.shape, &step.after).color(Color::INK).label("after"))
        .with(disc(step.start_w))
        .with(disc(end_w).fill(Color::GRAY, 0.4))
        .with(arrow(step.start_w, WAY * step.along).color(Color::GRAY).label("pusher"))
        .with(arrow(Vector2::zeros(), corner).color(Color::BLUE).width(2.2).label("Δx"))
        .with(arrow(corner, dy * left).color(Color::VERMILION).width(2.2).label("Δy"))
        .with(Points::at(&[[0.0, 0.0], (MM * moved).into()]).color(Color::INK))
}

fn turn(step: &Step) -> Panel {
    let angle = step.after.angle;
    let reach = 0.95 * SIDE;
    let ray = |angle: f64, length: f64| length * Vector2::new(angle.cos(), angle.sin());
    let arc: Vec<[f64; 2]> =
        (0..=30).map(|k| (MM * ray(angle * f64::from(k) / 30.0, 0.8 * reach)).into()).collect();
    let half = ray(0.5 * angle, 0.86 * reach);
    let turned = Pose::new(0.0, 0.0, angle);
    let axis = |direction: f64| {
        Line::through(&[[0.0, 0.0], (MM * ray(direction, reach)).into()]).width(1.2)
    };
    Panel::new(Axis::new("x / mm").range(-75.0, 105.0), Axis::new("y / mm").range(-70.0, 75.0))
        .equal_aspect()
        .legend(LegendPlace::Below)
        .with(outline(&step.shape, &Pose::default()).dashed().color(Color::GRAY).label("before"))
        .with(outline(&step.shape, &turned).color(Color::INK).label("after, moved back"))
        .with(axis(0.0).color(Color::GRAY).dashed())
        .with(axis(angle).color(Color::INK))
        .with(Line::through(&arc).color(Color::VERMILION).width(2.2).label("Δθ"))
        .with(
            Note::new((MM * half).into(), "Δθ")
                .color(Color::VERMILION)
                .anchor(Anchor::Start)
                .offset(4.0, -4.0),
        )
        .with(Points::at(&[[0.0, 0.0]]).color(Color::INK))
}

fn outline(shape: &Shape, pose: &Pose) -> Polygon {
    let corners: Vec<[f64; 2]> =
        shape.outline(4).iter().map(|c| (MM * pose.transform_point(c)).into()).collect();
    Polygon::new(&corners)
}

fn arrow(tail: Vector2<f64>, vector: Vector2<f64>) -> Arrows {
    Arrows::new(&[(MM * tail).into()], &[(MM * vector).into()])
}
