//! Figure 2.2: a pushed body turns about its center of rotation.

use anyhow::{Result, bail};
use mechanics::{CenterOfRotation, Ellipsoid, predict};
use nalgebra::Vector2;
use planar::Shape;
use report::{Arrows, Color, Ellipse, Figure, LegendPlace, Line, Note, Points, Table};

use super::top_view::{SIDE, arrow, in_mm, panel, push, pusher};
use crate::figures::inputs::Inputs;
use crate::figures::sketch::Sketch;

/// Height of the contact above the middle of its edge, in m, and the push's direction, in rad.
const HEIGHT: f64 = 0.03;
const DIRECTION: f64 = 0.5;
/// mm drawn for a velocity of 1 m/s.
const SCALE: f64 = 1500.0;

pub(crate) fn draw(_: &Inputs) -> Result<Sketch> {
    let shape = Shape::square(SIDE)?;
    let push = push(HEIGHT, DIRECTION);
    let twist = predict(&Ellipsoid::uniform(&shape, 1.0)?, &push)?.twist_ws_s;
    let CenterOfRotation::Point { at: center, .. } = CenterOfRotation::of(&twist) else {
        bail!("the square does not turn");
    };
    let marked = Vector2::new(0.028, 0.012);
    let mut points = shape.outline(1);
    points.extend([Vector2::zeros(), push.p_sc, marked]);
    let velocities: Vec<_> = points.iter().map(|point| twist.velocity_at(point)).collect();
    let table = table(&points, &velocities, &center);
    let tails: Vec<_> = points.iter().map(in_mm).collect();
    let vectors: Vec<_> = velocities.iter().map(|v| [v.x, v.y]).collect();
    let circle = |point: &Vector2<f64>| {
        Ellipse::circle(in_mm(&center), 1e3 * (point - center).norm()).color(Color::GRAY).dashed()
    };
    let radius = |point: &Vector2<f64>| {
        Line::through(&[in_mm(&center), in_mm(point)]).color(Color::GRAY).width(1.2)
    };
    let note = |at: &Vector2<f64>, text: &str| Note::new(in_mm(at), text);
    let panel = panel("", (-92.0, 92.0), (-70.0, 70.0))?
        .legend(LegendPlace::Below)
        .with(circle(&push.p_sc).width(0.9))
        .with(circle(&marked).width(0.9))
        .with(radius(&push.p_sc))
        .with(radius(&marked))
        .with(pusher(&push))
        .with(
            Arrows::new(&tails, &vectors)
                .scale(SCALE)
                .color(Color::BLUE)
                .label("velocity of the body"),
        )
        .with(
            arrow(&super::top_view::pusher_center(&push), &push.v_wp_s, SCALE)
                .color(Color::VERMILION)
                .label("velocity of the pusher"),
        )
        .with(Points::at(&tails).color(Color::BLUE).radius(2.5))
        .with(Points::at(&[in_mm(&center)]).color(Color::INK).radius(4.0))
        .with(note(&center, "COR").offset(8.0, -12.0))
        .with(note(&Vector2::zeros(), "COM").offset(6.0, -14.0))
        .with(note(&marked, "a").offset(4.0, -14.0))
        .with(note(&(0.5 * (center + marked)), "r").offset(6.0, -8.0));
    let caption = format!(
        "A push at 20 mm/s on the 90 mm square: at this instant the square turns at {:.1} °/s about \
         its center of rotation (COR) at ({:.1}, {:.1}) mm from its center of mass (COM). Each point a \
         moves across its line r to the COR with |ω| |r|: the center at {:.1} mm/s, the contact, \
         {:.1} mm from the COR, at {:.1} mm/s. An arrow is as long as the way in 1.5 s.",
        twist.angular.to_degrees(),
        1e3 * center.x,
        1e3 * center.y,
        1e3 * twist.linear.norm(),
        1e3 * (push.p_sc - center).norm(),
        1e3 * twist.velocity_at(&push.p_sc).norm(),
    );
    let alt = "A square from above with a pusher at its left edge; arrows at its corners, center and \
               contact run along circles about a point below.";
    let figure = Figure::new(1, 1).panel_size(560.0, 470.0).with(panel);
    Ok(Sketch::new(figure, table, &caption, alt))
}

fn table(points: &[Vector2<f64>], velocities: &[Vector2<f64>], center: &Vector2<f64>) -> Table {
    let columns = |of: &[Vector2<f64>]| -> [Vec<f64>; 2] {
        [of.iter().map(|v| 1e3 * v.x).collect(), of.iter().map(|v| 1e3 * v.y).collect()]
    };
    let ([x, y], [vx, vy]) = (columns(points), columns(velocities));
    let distance: Vec<_> = points.iter().map(|point| 1e3 * (point - center).norm()).collect();
    Table::new()
        .column("x_mm", &x)
        .column("y_mm", &y)
        .column("vx_mm_s", &vx)
        .column("vy_mm_s", &vy)
        .column("distance_to_cor_mm", &distance)
}
