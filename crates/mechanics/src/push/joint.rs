//! The push at several contacts at once.

use crate::numerics::root::root_bracket;
use crate::{
    ContactMode, LimitSurface, MechanicsError, Push, PushMotion, predict,
    predict_with_external_wrench,
};
use nalgebra::{Matrix3, Vector3};
use planar::{Twist, Wrench, cross};

/// What may be lost to rounding, relative to the speed of the pusher and to the load.
const ROUNDING: f64 = 1e-9;

/// The quasi-static motion under one rigid pusher that touches at several contacts, and a constant
/// `external_s` in N and N·m; one [`PushMotion`] for each contact, all with the slider's twist.
///
/// A contact presses or is [`ContactMode::Separated`] (the slider moves away from it). Of several
/// that press, either all stick and the slider is carried along without turning, or two slide: three
/// contacts, or one that sticks and one that slides, leave no other motion. The first that fits is
/// taken, in this order: one contact presses; all stick; two slide. Forces that sticking contacts
/// leave open (they may squeeze the slider between them) are those of the smallest sum.
///
/// # Errors
/// As [`predict_with_external_wrench`] for each contact; `PushersDiffer` for different velocities of the pusher;
/// `NotConverged` if no motion fits, which rounding only can cause.
pub fn predict_multi_contact<S: LimitSurface + ?Sized>(
    surface: &S,
    pushes: &[Push],
    external_s: &Wrench,
) -> Result<Vec<PushMotion>, MechanicsError> {
    for push in pushes {
        push.validate()?;
        if push.v_wp_s != pushes[0].v_wp_s {
            return Err(MechanicsError::PushersDiffer);
        }
    }
    let scale = pushes.first().map_or(1.0, Push::speed_scale);
    let slow: Vec<Push> = pushes.iter().map(|push| push.slowed_by(scale)).collect();
    let motions = at_unit_speed(surface, &slow, external_s)?;
    motions.into_iter().map(|motion| motion.sped_up_by(scale)).collect()
}

/// [`predict_multi_contact`] for a velocity whose squares neither over- nor underflow.
fn at_unit_speed<S: LimitSurface + ?Sized>(
    surface: &S,
    pushes: &[Push],
    external_s: &Wrench,
) -> Result<Vec<PushMotion>, MechanicsError> {
    if pushes.iter().all(|push| push.approach_speed() <= 0.0) {
        let level = surface.level(external_s)?;
        if level >= 1.0 {
            return Err(MechanicsError::SlidesByItself { level });
        }
        return Ok(pushes.iter().map(Push::separated).collect());
    }
    for (index, push) in pushes.iter().enumerate() {
        if push.approach_speed() > 0.0 {
            let motion = match *external_s == Wrench::default() {
                true => predict(surface, push)?,
                false => predict_with_external_wrench(surface, push, external_s)?,
            };
            if let Some(motions) = around(pushes, &[(index, motion)]) {
                return Ok(motions);
            }
        }
    }
    if let Some(motions) = carried(surface, pushes, external_s)? {
        return Ok(motions);
    }
    for second in 1..pushes.len() {
        for first in 0..second {
            for side in [1.0, -1.0] {
                let pair = [(first, &pushes[first]), (second, &pushes[second])];
                let pair = slide(surface, pair, side, external_s)?;
                if let Some(motions) = pair.and_then(|pair| around(pushes, &pair)) {
                    return Ok(motions);
                }
            }
        }
    }
    let (what, residual) = ("the push at several contacts", f64::INFINITY);
    Err(MechanicsError::NotConverged { what, iterations: 1, residual, tolerance: ROUNDING })
}

/// Adds the contacts that do not press, if the slider moves away from all of them.
fn around(pushes: &[Push], pressing: &[(usize, PushMotion)]) -> Option<Vec<PushMotion>> {
    let twist = pressing[0].1.twist_ws_s;
    let motion = |(index, push): (usize, &Push)| {
        if let Some((_, motion)) = pressing.iter().find(|(i, _)| *i == index) {
            return Some(*motion);
        }
        let relative = push.v_wp_s - twist.velocity_at(&push.p_sc);
        let parts = push.normal_s.dot(&relative) <= ROUNDING * push.v_wp_s.norm();
        parts.then(|| push.motion(ContactMode::Separated, twist, nalgebra::Vector2::zeros()))
    };
    pushes.iter().enumerate().map(motion).collect()
}

/// All contacts stick: the slider translates with the pusher, if their cones hold the load.
fn carried<S: LimitSurface + ?Sized>(
    surface: &S,
    pushes: &[Push],
    external_s: &Wrench,
) -> Result<Option<Vec<PushMotion>>, MechanicsError> {
    let twist = Twist { linear: pushes[0].v_wp_s, angular: 0.0 };
    let scale = surface.characteristic_length();
    let load = scaled(&(surface.wrench(&twist)? - *external_s), scale);
    let modes = [ContactMode::SlidingLeft, ContactMode::SlidingRight];
    let rays: Vec<(usize, _, Vector3<f64>)> = pushes
        .iter()
        .enumerate()
        .flat_map(|(index, push)| {
            modes.map(|mode| {
                let force = push.edge_of(mode);
                (index, force, scaled(&push.wrench_of(&force), scale))
            })
        })
        .collect();
    let mut best: Option<(f64, [usize; 3], Vector3<f64>)> = None;
    for i in 2..rays.len() {
        for j in 1..i {
            for k in 0..j {
                let columns = Matrix3::from_columns(&[rays[i].2, rays[j].2, rays[k].2]);
                let Some(shares) = columns.lu().solve(&load) else { continue };
                let residual = (columns * shares - load).norm();
                let fits = shares.min() >= -ROUNDING * shares.amax();
                let sum = shares.sum();
                if fits
                    && residual <= ROUNDING * load.norm()
                    && best.is_none_or(|(least, ..)| sum < least)
                {
                    best = Some((sum, [i, j, k], shares));
                }
            }
        }
    }
    Ok(best.map(|(_, chosen, shares)| {
        let force_on = |index: usize| {
            let forces = chosen.iter().zip(shares.iter()).filter(|(ray, _)| rays[**ray].0 == index);
            forces.map(|(ray, share)| share.max(0.0) * rays[*ray].1).sum()
        };
        let motion = |(index, push): (usize, &Push)| {
            push.motion(ContactMode::Sticking, twist, force_on(index))
        };
        pushes.iter().enumerate().map(motion).collect()
    }))
}

/// Two contacts slide while the slider turns about the point where their normals meet: to one side.
///
/// The motion is (v, 0) + τ k with τ ≥ 0 and k along both walls; τ is where the load comes to lie in
/// the plane of the two forces.
fn slide<S: LimitSurface + ?Sized>(
    surface: &S,
    pair: [(usize, &Push); 2],
    side: f64,
    external_s: &Wrench,
) -> Result<Option<[(usize, PushMotion); 2]>, MechanicsError> {
    let scale = surface.characteristic_length();
    let speed = pair[0].1.v_wp_s.norm();
    let [first, second] = pair.map(|(_, push)| {
        let normal = push.normal_s.into_inner();
        Vector3::new(normal.x, normal.y, cross(&push.p_sc, &normal) / scale)
    });
    let along = side * first.cross(&second);
    if along.norm() <= ROUNDING {
        return Ok(None);
    }
    let along = speed * along.normalize();
    let turn = Twist::new(along.x, along.y, along.z / scale);
    let modes = pair.map(|(_, push)| {
        if push.tangent_s().dot(&turn.velocity_at(&push.p_sc)) < 0.0 {
            ContactMode::SlidingLeft
        } else {
            ContactMode::SlidingRight
        }
    });
    let forces = [0, 1].map(|k| pair[k].1.edge_of(modes[k]));
    let rays = [0, 1].map(|k| scaled(&pair[k].1.wrench_of(&forces[k]), scale));
    let across = rays[0].cross(&rays[1]);
    let ahead = Twist { linear: pair[0].1.v_wp_s, angular: 0.0 };
    let at = |share: f64| (1.0 - share) * ahead + share * turn;
    let load = |share: f64| -> Result<Vector3<f64>, MechanicsError> {
        Ok(scaled(&(surface.wrench(&at(share))? - *external_s), scale))
    };
    let (start, end) = (across.dot(&load(0.0)?), across.dot(&load(1.0)?));
    if start == end || (start != 0.0 && end != 0.0 && (start > 0.0) == (end > 0.0)) {
        return Ok(None);
    }
    let rising = (end - start).signum();
    let what = "two sliding contacts";
    let (low, high) =
        root_bracket(what, (0.0, rising * start), (1.0, rising * end), 1e-15, |share| {
            Ok(rising * across.dot(&load(share)?))
        })?;
    let share = 0.5 * (low.0 + high.0);
    if share >= 1.0 {
        return Ok(None);
    }
    let load = load(share)?;
    let size = across.norm_squared();
    let shares =
        [load.cross(&rays[1]).dot(&across) / size, rays[0].cross(&load).dot(&across) / size];
    if shares.iter().any(|share| *share < 0.0) {
        return Ok(None);
    }
    // Without friction, walls that carry the slider along have their forces here, too.
    let (twist, modes) = match share <= ROUNDING {
        true => (ahead, [ContactMode::Sticking; 2]),
        false => (1.0 / (1.0 - share) * at(share), modes),
    };
    let motion = |k: usize| {
        let (index, push) = pair[k];
        (index, push.motion(modes[k], twist, shares[k] * forces[k]))
    };
    Ok(Some([motion(0), motion(1)]))
}

/// A load as (fx, fy, M/ρ).
fn scaled(load: &Wrench, length: f64) -> Vector3<f64> {
    Vector3::new(load.force.x, load.force.y, load.torque / length)
}
