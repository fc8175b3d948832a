//! Prediction of a step with the machinery of effects.

use std::sync::Arc;

use anyhow::Result;
use effects::{Object, PushPhysics, Rig, StepInput, Surface, Track, all};
use mechanics::{Ellipsoid, LimitSurface, Patch, Push, predict};
use nalgebra::{UnitVector2, Vector2};
use planar::{Pose, Shape, Twist};

use super::benchmark::Benchmark;
use super::timing::{Case, Row};

pub(super) const BENCHMARK: Benchmark = Benchmark {
    name: "effects",
    about: "all channels of 4 mm steps of a square, beside a plain midpoint loop of single pushes",
    rows: |_| rows(),
};

const RADIUS: f64 = 0.00475;
const FRICTION: f64 = 0.25;
const SIDE: f64 = 0.09;
const MASS: f64 = 0.8374;
const SUBSTEPS: usize = 4;

fn rows() -> Result<Vec<Row>> {
    let steps = steps()?;
    let shape = Shape::square(SIDE)?;
    let f_max = FRICTION * MASS * 9.81;
    let (ellipsoid, patch) = (Ellipsoid::uniform(&shape, f_max)?, Patch::uniform(&shape, f_max)?);
    let model =
        |surface| Ok::<_, anyhow::Error>(PushPhysics::new(Rig::new(surface, FRICTION, FRICTION)?));
    let plain = model(Surface::Ellipsoid)?;
    let exact = model(Surface::UniformPatch)?;
    let mut every = plain.clone();
    for effect in all() {
        every = every.with(effect, &effect.info().typical(plain.rig()))?;
    }
    Ok(vec![
        row("ellipsoid", 20, &plain, &steps, &ellipsoid),
        row("exact patch", 3, &exact, &steps, &patch),
        row("ellipsoid, all effects", 3, &every, &steps, &ellipsoid),
    ])
}

fn row(
    name: &str,
    turns: usize,
    physics: &PushPhysics,
    steps: &[StepInput],
    surface: &dyn LimitSurface,
) -> Row {
    let size = steps.len();
    let case = Case { name, size, threads: 1, rounds: 7, calls: turns };
    case.compare(
        || physics.predict_all(steps).expect("the benchmark's steps are ordinary"),
        || steps.iter().map(|step| plain_loop(step, surface)).collect::<Vec<_>>(),
    )
}

/// One thousand pushes over the square's edges, places, angles and orientations.
fn steps() -> Result<Vec<StepInput>> {
    let shape = Arc::new(Shape::square(SIDE)?);
    let object = Arc::new(Object::uniform(shape.clone(), MASS)?);
    let step = |index: usize| {
        let share = |prime: usize| (index * prime % 1009) as f64 / 1009.0;
        let (edge, p, beta) = (index % 4, 0.05 + 0.9 * share(17), 1.4 * (share(101) - 0.5));
        let pose_wb = Pose::new(share(7), share(29), 6.0 * share(43));
        let normal = shape.inward_normal_at(edge, p);
        let start = pose_wb.transform_point(&(shape.point_at(edge, p) - RADIUS * normal));
        let way = pose_wb.rotate(&Pose::new(0.0, 0.0, beta).rotate(&(0.004 * normal)));
        StepInput {
            object: object.clone(),
            pusher_radius: RADIUS,
            pose_wb,
            twist_wb: Twist::default(),
            track: Track::straight(start, start + way, 0.2),
            touching: true,
            since_contact: 1.0,
            run_up: None,
            progress: share(11),
            session: 0,
        }
    };
    Ok((0..1000).map(step).collect())
}

/// The motion alone, by the midpoint rule and nothing but `mechanics`; the way to a middle follows
/// from the moments before, as in `effects`.
fn plain_loop(step: &StepInput, surface: &dyn LimitSurface) -> Pose {
    let length = step.track.duration() / SUBSTEPS as f64;
    let velocity = step.track.mean_velocity();
    let contact = |time: f64, pose: &Pose| {
        let center = pose.inverse_transform_point(&(step.track.start() + time * velocity));
        step.object.shape().contact(&center, RADIUS)
    };
    let twist = |time: f64, pose: &Pose| {
        let contact = contact(time, pose);
        let push = Push {
            p_sc: contact.point,
            normal_s: UnitVector2::new_unchecked(contact.normal),
            v_wp_s: pose.inverse_rotate(&velocity),
            friction: FRICTION,
        };
        let motion = predict(surface, &push).expect("the benchmark's pushes are ordinary");
        Twist { linear: pose.rotate(&motion.twist_ws_s.linear), ..motion.twist_ws_s }
    };
    let moved = |pose: &Pose, twist: &Twist, time: f64| Pose {
        position: pose.position + time * twist.linear,
        angle: pose.angle + time * twist.angular,
    };
    let mut pose = step.pose_wb;
    let (mut early, mut before) = (0.0, twist(0.0, &pose));
    let (mut late, mut last) = (0.0, before);
    for k in 0..SUBSTEPS {
        let time = k as f64 * length;
        let foreseen = match k {
            0 => before,
            _ => {
                let ahead = (time + 0.25 * length - late) / (late - early);
                last + ahead * (last + -1.0 * before)
            }
        };
        let middle = moved(&pose, &foreseen, 0.5 * length);
        (early, before) = (late, last);
        (late, last) = (time + 0.5 * length, twist(time + 0.5 * length, &middle));
        pose = moved(&pose, &last, length);
        let end = contact(time + length, &pose);
        let shift: Vector2<f64> = -end.gap * pose.rotate(&end.normal);
        pose.position += shift;
    }
    pose
}

#[cfg(test)]
mod tests {
    use effects::{PushPhysics, Rig, Surface};
    use mechanics::Ellipsoid;
    use planar::Shape;

    use super::{FRICTION, SIDE, plain_loop, steps};

    #[test]
    fn both_sides_predict_the_same_motion() {
        let physics = PushPhysics::new(Rig::new(Surface::Ellipsoid, FRICTION, FRICTION).unwrap());
        let surface = Ellipsoid::uniform(&Shape::square(SIDE).unwrap(), 2.0).unwrap();
        for step in steps().unwrap() {
            let channels = physics.predict(&step).unwrap();
            let pose = plain_loop(&step, &surface);
            let moved = step.direction_w().dot(&(pose.position - step.pose_wb.position));
            assert!((channels.dx - moved).abs() < 1e-12);
            assert!((channels.dtheta - (pose.angle - step.pose_wb.angle)).abs() < 1e-11);
        }
    }
}
