//! Figure 2.4: the motion cone from the friction cone's edges and their centers of rotation.

use anyhow::{Result, bail};
use mechanics::{CenterOfRotation, Ellipsoid, FrictionCone, MotionCone, Push};
use nalgebra::{UnitVector2, Vector2};
use planar::{Shape, perpendicular};
use report::{Anchor, Color, Figure, LegendPlace, Line, Note, Panel, Points};
use serde_json::json;

use super::top_view::{SIDE, cone, in_mm, panel, push, pusher};
use crate::figures::inputs::Inputs;
use crate::figures::sketch::Sketch;

/// Height of the contact above the middle of its edge, in m.
const HEIGHT: f64 = 0.03;
/// Length of the cones drawn, in mm.
const LENGTH: f64 = 62.0;

pub(crate) fn draw(_: &Inputs) -> Result<Sketch> {
    let surface = Ellipsoid::uniform(&Shape::square(SIDE)?, 1.0)?;
    let push = push(HEIGHT, 0.0);
    let friction = FrictionCone::new(push.normal_s, push.friction)?.edges();
    let motion = MotionCone::new(&surface, &push)?;
    let constructed = MotionCone::edges_from_centers(&push.p_sc, &motion.centers())?;
    let edges = [motion.left, motion.right];
    let difference = edges.iter().zip(&constructed).map(|(a, b)| a.angle(b)).fold(0.0, f64::max);
    let mut centers = Vec::new();
    for center in motion.centers() {
        let CenterOfRotation::Point { at, .. } = center else { bail!("an edge does not turn") };
        centers.push(at);
    }
    let degrees = edges.map(|edge| edge.y.atan2(edge.x).to_degrees());
    let data = json!({
        "contact_mm": in_mm(&push.p_sc),
        "friction_cone_deg": friction.map(|edge| edge.y.atan2(edge.x).to_degrees()),
        "motion_cone_deg": degrees,
        "centers_of_rotation_mm": centers.iter().map(in_mm).collect::<Vec<_>>(),
        "largest_difference_of_constructions_rad": difference,
    });
    let panel = picture(&push, &friction, &edges, &centers)?;
    let caption = format!(
        "A force along the left edge of the friction cone turns the square about the left COR, one \
         along the right edge about the right COR. The contact then moves across the line to that \
         COR: these two directions, {:.1}° and {:.1}° from the normal, bound the motion cone. Built \
         from the CORs and from the normals of the limit surface, the edges agree within {} rad.",
        degrees[0],
        degrees[1],
        upper_bound(difference),
    );
    let alt = "A square from above with a pusher at its left edge, the two cones that open from the \
               contact and two centers of rotation below.";
    let figure = Figure::new(1, 1).panel_size(480.0, 540.0).with(panel);
    Ok(Sketch::new(figure, data, &caption, alt))
}

fn picture(
    push: &Push,
    friction: &[UnitVector2<f64>; 2],
    edges: &[UnitVector2<f64>; 2],
    centers: &[Vector2<f64>],
) -> Result<Panel> {
    let mut panel = panel("", (-70.0, 70.0), (-75.0, 80.0))?
        .legend(LegendPlace::Below)
        .with(
            cone(&push.p_sc, friction, LENGTH)
                .color(Color::ORANGE)
                .fill(Color::ORANGE, 0.3)
                .label("friction cone (forces)"),
        )
        .with(
            cone(&push.p_sc, edges, LENGTH)
                .color(Color::BLUE)
                .fill(Color::BLUE, 0.25)
                .label("motion cone (velocities)"),
        );
    let names = ["left", "right"];
    let colors = [Color::PURPLE, Color::GREEN];
    let tip = |edge: &UnitVector2<f64>| in_mm(&(push.p_sc + 1e-3 * LENGTH * edge.into_inner()));
    for k in 0..2 {
        let to_center = Line::through(&[in_mm(&push.p_sc), in_mm(&centers[k])]);
        // Small squares, one within the other, show that edge and line are perpendicular.
        let size = [0.007, 0.0045][k];
        let (along, across) = (edges[k].into_inner(), -perpendicular(&edges[k]));
        let mark = [along, along + across, across].map(|d| in_mm(&(push.p_sc + size * d)));
        panel = panel
            .with(to_center.color(colors[k]).dashed())
            .with(Line::through(&mark).color(colors[k]).width(1.2))
            .with(Points::at(&[in_mm(&centers[k])]).color(colors[k]).radius(4.5))
            .with(
                Note::new(tip(&friction[k]), names[k])
                    .anchor(Anchor::End)
                    .offset(-8.0, [-18.0, 12.0][k]),
            )
            .with(Note::new(tip(&edges[k]), names[k]).offset(5.0, [2.0, -4.0][k]))
            .with(Note::new(in_mm(&centers[k]), &format!("COR {}", names[k])).offset(9.0, -4.0));
    }
    Ok(panel
        .with(pusher(push))
        .with(Points::at(&[[0.0, 0.0]]).color(Color::INK).radius(3.0))
        .with(Note::new([0.0, 0.0], "COM").offset(6.0, -14.0)))
}

/// The power of ten that bounds a value; at least rounding.
fn upper_bound(value: f64) -> String {
    format!("1e{}", value.max(f64::EPSILON).log10().ceil())
}
