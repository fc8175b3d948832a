//! Figure 2.3: the pusher's friction cone and the friction of each element of the support.

use anyhow::{Result, bail};
use mechanics::{CenterOfRotation, FrictionCone, Patch, Push, PushMotion, predict};
use nalgebra::Vector2;
use planar::{Twist, Wrench, mit_object};
use report::{Arrows, Color, Figure, Note, Panel, Points, Table};

use super::top_view::{PUSHER, SIDE, arrow, cone, in_mm, panel, push, pusher};
use crate::figures::inputs::Inputs;
use crate::figures::sketch::Sketch;

/// Friction with the table, and gravity in m/s².
const TABLE_FRICTION: f64 = 0.25;
const GRAVITY: f64 = 9.806_65;
/// Height of the contact above the middle of its edge, in m, and the push's direction, in rad.
const HEIGHT: f64 = 0.03;
const DIRECTION: f64 = 0.5;
/// Elements along each side.
const N: u32 = 10;

pub(crate) fn draw(_: &Inputs) -> Result<Sketch> {
    let square = mit_object("rect1")?;
    let f_max = TABLE_FRICTION * square.mass * GRAVITY;
    let push = push(HEIGHT, DIRECTION);
    let motion = predict(&Patch::uniform(&square.shape, f_max)?, &push)?;
    let elements = elements(&motion.twist_ws_s, f_max);
    let friction = elements
        .iter()
        .fold(Wrench::default(), |sum, (at, force)| sum + Wrench::from_force_at(force, at));
    let column = |of: fn(&(Vector2<f64>, Vector2<f64>)) -> f64| -> Vec<f64> {
        elements.iter().map(of).collect()
    };
    let table = Table::new()
        .column("x_mm", &column(|(at, _)| 1e3 * at.x))
        .column("y_mm", &column(|(at, _)| 1e3 * at.y))
        .column("fx_mn", &column(|(_, force)| 1e3 * force.x))
        .column("fy_mn", &column(|(_, force)| 1e3 * force.y));
    let figure = Figure::new(1, 2)
        .panel_size(430.0, 400.0)
        .one_legend()
        .with(pusher_panel(&push, &motion)?)
        .with(support_panel(&push, &motion, &elements)?);
    let pushed = push.wrench_of(&motion.force_s);
    let caption = format!(
        "(a) The pusher's force is within its friction cone, {:.1}° to either side of the normal: \
         here {:.2} N at {:+.1}°. (b) Every element of the uniformly loaded square resists its own \
         slip with the same {:.1} mN; only its direction depends on where it is. Together the \
         {N} × {N} elements resist with ({:.3}, {:.3}) N and {:.1} mN·m about the center; the push, \
         computed with the pressure as a continuum, is ({:.3}, {:.3}) N and {:.1} mN·m.",
        PUSHER.friction.atan().to_degrees(),
        motion.force_s.norm(),
        motion.force_s.y.atan2(motion.force_s.x).to_degrees(),
        1e3 * f_max / f64::from(N * N),
        friction.force.x,
        friction.force.y,
        1e3 * friction.torque,
        pushed.force.x,
        pushed.force.y,
        1e3 * pushed.torque,
    );
    let alt = "A square from above: on the left the cone of the pusher's forces, on the right a grid \
               of friction arrows that circle about the center of rotation.";
    Ok(Sketch::new(figure, table, &caption, alt))
}

/// Places of the elements, in m, and friction on them, in N.
fn elements(twist: &Twist, f_max: f64) -> Vec<(Vector2<f64>, Vector2<f64>)> {
    let at = |k: u32| SIDE * ((f64::from(k) + 0.5) / f64::from(N) - 0.5);
    let places = (0..N).flat_map(|row| (0..N).map(move |column| Vector2::new(at(column), at(row))));
    let share = f_max / f64::from(N * N);
    places.map(|at| (at, -share * twist.velocity_at(&at).normalize())).collect()
}

fn pusher_panel(push: &Push, motion: &PushMotion) -> Result<Panel> {
    let edges = FrictionCone::new(push.normal_s, push.friction)?.edges();
    let normal = push.normal_s.into_inner();
    Ok(panel("pusher on object", (-62.0, 3.0), (2.0, 57.0))?
        .with(
            cone(&push.p_sc, &edges, 34.0)
                .color(Color::ORANGE)
                .fill(Color::ORANGE, 0.3)
                .label("friction cone"),
        )
        .with(arrow(&push.p_sc, &normal, 40.0).color(Color::GRAY).width(1.2).label("normal"))
        .with(pusher(push))
        .with(
            arrow(&push.p_sc, &motion.force_s, 15.0)
                .color(Color::VERMILION)
                .label("force on the object"),
        ))
}

fn support_panel(
    push: &Push,
    motion: &PushMotion,
    elements: &[(Vector2<f64>, Vector2<f64>)],
) -> Result<Panel> {
    let CenterOfRotation::Point { at: center, .. } = CenterOfRotation::of(&motion.twist_ws_s)
    else {
        bail!("the square does not turn");
    };
    let tails: Vec<_> = elements.iter().map(|(at, _)| in_mm(at)).collect();
    let forces: Vec<_> = elements.iter().map(|(_, force)| [force.x, force.y]).collect();
    let length = elements[0].1.norm();
    Ok(panel("support on object", (-75.0, 55.0), (-55.0, 55.0))?
        .with(pusher(push))
        .with(Points::at(&tails).color(Color::BLUE).radius(1.5))
        .with(
            Arrows::new(&tails, &forces)
                .scale(7.5 / length)
                .color(Color::BLUE)
                .label("friction on an element"),
        )
        .with(Points::at(&[[0.0, 0.0]]).color(Color::INK).radius(3.0))
        .with(Note::new([0.0, 0.0], "COM"))
        .with(Points::at(&[in_mm(&center)]).color(Color::VERMILION).radius(3.0))
        .with(Note::new(in_mm(&center), "COR").offset(8.0, -3.0)))
}
