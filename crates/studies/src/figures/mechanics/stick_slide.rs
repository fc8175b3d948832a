//! Figure 2.10: a sticking and a sliding push.

use anyhow::{Context, Result};
use mechanics::{
    ContactMode, Ellipsoid, MotionCone, PathSettings, Push, PushMotion, Slider, StraightPath,
    predict, push_along,
};
use planar::{Pose, Shape};
use report::{Color, Ellipse, Figure, Panel};
use serde_json::{Value, json};

use super::top_view::{
    PUSHER, SIDE, SPEED, arrow, cone, in_mm, outline, panel, push, pusher, pusher_center,
};
use crate::figures::inputs::Inputs;
use crate::figures::sketch::Sketch;

/// Height of the contact above the middle of its edge, in m.
const HEIGHT: f64 = 0.03;
/// Directions of the pusher's velocity from the normal, in rad.
const DIRECTIONS: [f64; 2] = [0.5, -0.2];
/// Duration of the push whose end is drawn, in s.
const DURATION: f64 = 1.0;
/// mm drawn for a velocity of 1 m/s, and length of the cone in mm.
const SCALE: f64 = 2200.0;
const LENGTH: f64 = 62.0;

/// One panel's push, what it does at once, and where it ends.
struct Case {
    push: Push,
    cone: MotionCone,
    motion: PushMotion,
    end_ws: Pose,
}

pub(crate) fn draw(_: &Inputs) -> Result<Sketch> {
    let [sticking, sliding] = DIRECTIONS.map(Case::compute);
    let (sticking, sliding) = (sticking?, sliding?);
    let data = json!({ "sticking": sticking.data(), "sliding": sliding.data() });
    let (right, slip) = (sliding.cone.right, 1e3 * sliding.motion.slip);
    let contact_speed = sliding.motion.twist_ws_s.velocity_at(&sliding.push.p_sc).norm();
    // The thesis: the contact moves along the cone's edge with this share of the pusher's speed.
    let share = sliding.push.approach_speed() / (right.dot(&sliding.push.normal_s) * SPEED);
    let caption = format!(
        "The pusher at 20 mm/s, {:.1}° from the normal, is within the motion cone ({:.1}° to {:.1}°): \
         the contact sticks and moves with it. At {:.1}° it is outside: the contact moves along the \
         cone's right edge at {:.1} mm/s, which is {:.3} of the pusher's speed as the ratio of the \
         normal parts demands ({:.3}), and the pusher slips {:.1} mm/s to the {}. Dashed: the square \
         after {DURATION} s, turned by {:.1}° and {:.1}°. Arrows are as long as the way in 2.2 s.",
        DIRECTIONS[0].to_degrees(),
        angle(&sticking.cone.right),
        angle(&sticking.cone.left),
        DIRECTIONS[1].to_degrees(),
        1e3 * contact_speed,
        contact_speed / SPEED,
        share,
        slip.abs(),
        if slip > 0.0 { "left" } else { "right" },
        sticking.end_ws.angle.to_degrees(),
        sliding.end_ws.angle.to_degrees(),
    );
    let figure = Figure::new(1, 2)
        .panel_size(440.0, 430.0)
        .one_legend()
        .with(sticking.panel()?)
        .with(sliding.panel()?);
    let alt = "A square from above, twice, with a pusher at its left edge and the motion cone: the \
               pusher's velocity is inside the cone on the left and outside on the right.";
    Ok(Sketch::new(figure, data, &caption, alt))
}

fn angle(direction: &nalgebra::UnitVector2<f64>) -> f64 {
    direction.y.atan2(direction.x).to_degrees()
}

impl Case {
    fn compute(direction: f64) -> Result<Self> {
        let shape = Shape::square(SIDE)?;
        let surface = Ellipsoid::uniform(&shape, 1.0)?;
        let push = push(HEIGHT, direction);
        let slider = Slider { shape: &shape, surface: &surface, pose_bs: Pose::default() };
        let path = StraightPath {
            start_w: pusher_center(&push),
            velocity_w: push.v_wp_s,
            duration: DURATION,
        };
        let end = push_along(&slider, &PUSHER, &path, &Pose::default(), &PathSettings::default())?;
        let (cone, motion) = (MotionCone::new(&surface, &push)?, predict(&surface, &push)?);
        Ok(Self { push, cone, motion, end_ws: end.pose_wb })
    }

    fn title(&self) -> Result<&'static str> {
        match self.motion.mode {
            ContactMode::Sticking => Some("the pusher sticks"),
            ContactMode::SlidingLeft => Some("the pusher slides to the left"),
            ContactMode::SlidingRight => Some("the pusher slides to the right"),
            ContactMode::Separated => None,
        }
        .context("the pusher does not touch")
    }

    fn panel(&self) -> Result<Panel> {
        let push = &self.push;
        let at_contact = self.motion.twist_ws_s.velocity_at(&push.p_sc);
        let edges = [self.cone.left, self.cone.right];
        let end = pusher_center(push) + DURATION * push.v_wp_s;
        Ok(panel(self.title()?, (-70.0, 85.0), (-70.0, 85.0))?
            .with(
                outline(&self.end_ws)?
                    .color(Color::GRAY)
                    .dashed()
                    .label(&format!("after {DURATION} s")),
            )
            .with(Ellipse::circle(in_mm(&end), 1e3 * PUSHER.radius).color(Color::GRAY).dashed())
            .with(
                cone(&push.p_sc, &edges, LENGTH)
                    .color(Color::BLUE)
                    .fill(Color::BLUE, 0.2)
                    .label("motion cone"),
            )
            .with(pusher(push))
            .with(
                arrow(&push.p_sc, &at_contact, SCALE)
                    .color(Color::BLUE)
                    .width(3.4)
                    .label("contact's velocity"),
            )
            .with(
                arrow(&push.p_sc, &push.v_wp_s, SCALE)
                    .color(Color::VERMILION)
                    .width(1.8)
                    .label("pusher's velocity"),
            )
            .with(
                arrow(&nalgebra::Vector2::zeros(), &self.motion.twist_ws_s.linear, SCALE)
                    .color(Color::GREEN)
                    .label("center's velocity"),
            ))
    }

    fn data(&self) -> Value {
        let (twist, end) = (&self.motion.twist_ws_s, &self.end_ws);
        json!({
            "mode": format!("{:?}", self.motion.mode),
            "contact_mm": in_mm(&self.push.p_sc),
            "motion_cone_deg": [angle(&self.cone.left), angle(&self.cone.right)],
            "pusher_mm_s": in_mm(&self.push.v_wp_s),
            "contact_mm_s": in_mm(&twist.velocity_at(&self.push.p_sc)),
            "center_mm_s": in_mm(&twist.linear),
            "rate_deg_s": twist.angular.to_degrees(),
            "slip_mm_s": 1e3 * self.motion.slip,
            "end_mm": in_mm(&end.position),
            "end_deg": end.angle.to_degrees(),
        })
    }
}
