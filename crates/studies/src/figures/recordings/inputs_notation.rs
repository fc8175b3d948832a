//! Figure 4.5: contact position p and direction β on the square.

use anyhow::Result;
use nalgebra::Vector2;
use planar::{Pose, Shape};
use report::{Anchor, Arrows, Color, Ellipse, Figure, Line, Note, Panel, Points, Polygon, Table};

use crate::figures::inputs::Inputs;
use crate::figures::sketch::Sketch;

/// The thesis' square and pusher, in mm.
const SIDE: f64 = 90.0;
const RADIUS: f64 = 4.75;
/// The edge and position whose directions are drawn.
const EDGE: usize = 1;
const P: f64 = 0.3;
const DIRECTIONS_DEG: [f64; 8] = [-80.0, -60.0, -40.0, -20.0, 20.0, 40.0, 60.0, 80.0];
const ARROW: f64 = 32.0;

pub(crate) fn draw(_: &Inputs) -> Result<Sketch> {
    let shape = Shape::square(SIDE)?;
    let figure = Figure::new(1, 2)
        .panel_size(400.0, 380.0)
        .with(positions(&shape).title("contact position p"))
        .with(directions(&shape).title("push direction β"));
    let table = grid(&shape);
    let caption = "Left: edges are numbered from 0, counter-clockwise, and p runs from 0 to 1 along \
                   each. Right: β is the angle from the inward normal at the contact to the \
                   pusher's velocity, counter-clockwise positive; here on edge 1 at p = 0.3.";
    let alt = "A square with numbered edges, and a disc at its left edge with arrows from −80° to \
               80° about the normal.";
    Ok(Sketch::new(figure, table, caption, alt))
}

fn positions(shape: &Shape) -> Panel {
    let mut panel = square_panel(shape);
    for edge in 0..shape.n_edges() {
        let normal = shape.inward_normal_at(edge, 0.5);
        let at = |p: f64, inward: f64| shape.point_at(edge, p) + inward * normal;
        let marks: Vec<[f64; 2]> = (0..=10).map(|k| at(f64::from(k) / 10.0, 0.0).into()).collect();
        let tail = at(0.25, -16.0);
        let way: [f64; 2] = (at(0.75, -16.0) - tail).into();
        panel = panel
            .with(Points::at(&marks).radius(2.5))
            .with(Arrows::new(&[tail.into()], &[way]).color(Color::VERMILION))
            .with(centered(at(0.5, 15.0), &format!("edge {edge}")));
        for p in [0.1, 0.5, 0.9] {
            panel = panel.with(centered(at(p, -7.0), &p.to_string()));
        }
    }
    panel
}

fn directions(shape: &Shape) -> Panel {
    let normal = shape.inward_normal_at(EDGE, P);
    let contact = shape.point_at(EDGE, P);
    let center = contact - RADIUS * normal;
    let turned = |degrees: f64, length: f64| {
        length * Pose::new(0.0, 0.0, degrees.to_radians()).rotate(&normal)
    };
    let mut panel = square_panel(shape)
        .with(Ellipse::circle(center.into(), RADIUS).fill(Color::GRAY, 0.4))
        .with(
            Line::through(&[(contact - 8.0 * normal).into(), (contact + 48.0 * normal).into()])
                .color(Color::GRAY)
                .dashed(),
        );
    for degrees in DIRECTIONS_DEG {
        let text = format!("{degrees}°").replace('-', "\u{2212}");
        let end = contact + turned(degrees, ARROW + 6.0);
        let arrow = Arrows::new(&[contact.into()], &[turned(degrees, ARROW).into()]);
        panel = panel.with(arrow.color(Color::BLUE)).with(centered(end, &text).color(Color::BLUE));
    }
    let arc: Vec<[f64; 2]> =
        (0..=20).map(|k| (contact + turned(f64::from(k) * 2.0, 16.0)).into()).collect();
    panel
        .with(Line::through(&arc).color(Color::VERMILION))
        .with(centered(contact + turned(30.0, 19.5), "β").color(Color::VERMILION))
        .with(Note::new((contact + 48.0 * normal).into(), "normal (β = 0)").offset(4.0, -4.0))
}

fn square_panel(shape: &Shape) -> Panel {
    let corners: Vec<[f64; 2]> = shape.outline(4).into_iter().map(Into::into).collect();
    let reach = 0.5 * SIDE + 20.0;
    Panel::new(
        report::Axis::new("body x / mm").range(-reach, reach),
        report::Axis::new("body y / mm").range(-reach, reach),
    )
    .equal_aspect()
    .with(Polygon::new(&corners).fill(Color::GRAY, 0.08))
}

fn centered(at: Vector2<f64>, text: &str) -> Note {
    Note::new(at.into(), text).offset(0.0, -4.0).anchor(Anchor::Middle)
}

/// The thesis' grid of contacts and directions, in the body frame.
fn grid(shape: &Shape) -> Table {
    let mut columns: [Vec<f64>; 6] = Default::default();
    for edge in 0..shape.n_edges() {
        for k in 0..=10 {
            let p = f64::from(k) / 10.0;
            let (point, normal) = (shape.point_at(edge, p), shape.inward_normal_at(edge, p));
            let values = [edge as f64, p, point.x, point.y, normal.x, normal.y];
            columns.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
        }
    }
    let names = ["edge", "p", "x_mm", "y_mm", "inward_normal_x", "inward_normal_y"];
    names.iter().zip(&columns).fold(Table::new(), |table, (name, c)| table.column(name, c))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use planar::{Shape, cross};

    use super::{EDGE, P, SIDE};

    /// A pusher that moves at β = 90° goes towards decreasing p, as the picture shows.
    #[test]
    fn positive_directions_lean_towards_decreasing_p() {
        let shape = Shape::square(SIDE).unwrap();
        let normal = shape.inward_normal_at(EDGE, P);
        let left = planar::Pose::new(0.0, 0.0, FRAC_PI_2).rotate(&normal);
        let along = shape.point_at(EDGE, P + 0.1) - shape.point_at(EDGE, P);
        assert!(along.dot(&left) < 0.0 && cross(&normal, &left) > 0.0);
    }
}
