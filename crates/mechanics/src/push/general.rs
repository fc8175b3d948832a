//! The push on any limit surface, alone or with loads besides the pusher's.

use crate::numerics::root::{Sample, root_bracket};
use crate::push::quadric::quadric_push;
use crate::{ContactMode, LimitSurface, MechanicsError, Push, PushMotion, WrenchSet};
use nalgebra::Vector2;
use planar::{Twist, Wrench, cross, perpendicular};

const MAX_DOUBLINGS: usize = 200;
/// Width of the final bracket of the angular velocity, relative to it and to |v|/c.
const TOLERANCE: f64 = 1e-14;

/// The quasi-static motion of a slider that is pushed at one contact.
///
/// A pusher that does not approach (normal · velocity ≤ 0, a pusher at rest or moving along the
/// edge included) leaves the slider at rest: [`ContactMode::Separated`]. The motion scales with the
/// pusher's velocity; the force does not depend on its size.
///
/// # Errors
/// A push with a component that is not finite or a negative friction, or a solver that did not
/// converge.
///
/// # Source
/// Lynch, Maekawa & Tanie (1992), "Manipulation and active sensing by pushing using tactile
/// feedback", for the ellipsoid; Goyal, Ruina & Papadopoulos (1991) for the general surface.
pub fn predict<S: LimitSurface + ?Sized>(
    surface: &S,
    push: &Push,
) -> Result<PushMotion, MechanicsError> {
    match surface.quadric() {
        Some(matrix) => quadric_push(matrix, push),
        None => predict_with_external_wrench(surface, push, &Wrench::default()),
    }
}

/// The quasi-static motion under a push and a constant `external_s`, such as gravity on a tilted table.
///
/// `external_s` acts on the slider, in N and N·m, frame S. Solved through `surface` alone, to 1e-9 of
/// the motion for smooth surfaces (tested against the closed form of the ellipsoid):
///
/// 1. The contact forces that the surface can bear are a convex set around the origin. As the force
///    turns, the normal of that set, which is the contact's velocity, turns the same way. The
///    velocities at the two edges of the friction cone hence bound those of sticking.
/// 2. Sliding: the force is on the cone's edge, the motion is scaled to the approach speed.
/// 3. Sticking: the motion minimizes dissipation − external power over the angular velocity, at the
///    given velocity of the contact point; the moment about the contact vanishes there.
///
/// Where the surface leaves the contact force undecided (a center of rotation on a support point),
/// it is the one inside the friction cone that is nearest to the middle of the choices.
///
/// # Errors
/// `SlidesByItself` if the surface cannot bear `external_s`, whatever the pusher does; a push or
/// load that is not finite; a negative friction; a solver that did not converge.
pub fn predict_with_external_wrench<S: LimitSurface + ?Sized>(
    surface: &S,
    push: &Push,
    external_s: &Wrench,
) -> Result<PushMotion, MechanicsError> {
    push.validate()?;
    let scale = push.speed_scale();
    let motion = at_unit_speed(surface, &push.slowed_by(scale), external_s)?;
    motion.sped_up_by(scale)
}

/// [`predict_with_external_wrench`] for a velocity whose squares neither over- nor underflow.
fn at_unit_speed<S: LimitSurface + ?Sized>(
    surface: &S,
    push: &Push,
    external_s: &Wrench,
) -> Result<PushMotion, MechanicsError> {
    let external_level = surface.level(external_s)?;
    if external_level >= 1.0 {
        return Err(MechanicsError::SlidesByItself { level: external_level });
    }
    if push.approach_speed() <= 0.0 {
        return Ok(push.separated());
    }
    for (mode, side) in [(ContactMode::SlidingLeft, 1.0), (ContactMode::SlidingRight, -1.0)] {
        let force_s = largest_force(surface, push, &push.edge_of(mode), external_s)?;
        let twist = surface.twist(&(*external_s + push.wrench_of(&force_s)))?;
        let velocity = twist.velocity_at(&push.p_sc);
        let departs = side * cross(&velocity, &push.v_wp_s) > 0.0;
        let approach = push.normal_s.dot(&velocity);
        if departs && approach > 0.0 {
            return Ok(push.motion(mode, push.approach_speed() / approach * twist, force_s));
        }
    }
    let (twist, force_s) = stick(surface, push, external_s)?;
    Ok(push.motion(ContactMode::Sticking, twist, force_s))
}

/// The force along `direction` at the contact that, with the external load, is on the surface.
fn largest_force<S: LimitSurface + ?Sized>(
    surface: &S,
    push: &Push,
    direction: &Vector2<f64>,
    external_s: &Wrench,
) -> Result<Vector2<f64>, MechanicsError> {
    let alone = *direction / surface.level(&push.wrench_of(direction))?;
    if *external_s == Wrench::default() {
        return Ok(alone);
    }
    let excess = |share: f64| -> Result<f64, MechanicsError> {
        Ok(surface.level(&(*external_s + push.wrench_of(&(share * alone))))? - 1.0)
    };
    // A gauge is subadditive: s = level(s·alone) ≤ level(external + s·alone) + level(−external).
    let most = 2.0 + surface.level(&(-1.0 * *external_s))?;
    let (low, high) = ((0.0, excess(0.0)?), (most, excess(most)?));
    let (low, high) = root_bracket("the force on the cone's edge", low, high, TOLERANCE, excess)?;
    Ok(0.5 * (low.0 + high.0) * alone)
}

/// The twist and the contact force that carry the contact point along with the pusher.
fn stick<S: LimitSurface + ?Sized>(
    surface: &S,
    push: &Push,
    external_s: &Wrench,
) -> Result<(Twist, Vector2<f64>), MechanicsError> {
    let c = surface.characteristic_length();
    let arm = perpendicular(&push.p_sc);
    let twist_at = |omega: f64| Twist { linear: push.v_wp_s - omega * arm, angular: omega };
    // The moment about the contact of what friction and the external load leave over.
    let moment = |omega: f64| -> Result<f64, MechanicsError> {
        let (load, reach) = match surface.wrenches(&twist_at(omega))? {
            WrenchSet::Point(wrench) => (wrench, 0.0),
            WrenchSet::Disc { center, at, radius } => (center, radius * (at - push.p_sc).norm()),
        };
        let value = (load - *external_s).shifted(&push.p_sc).torque;
        Ok(if value.abs() <= reach { 0.0 } else { value })
    };
    let speed = push.v_wp_s.norm() / c;
    let size = c * c + arm.norm_squared();
    let guess = if size > 0.0 { arm.dot(&push.v_wp_s) / size } else { 0.0 };
    let (low, high) = sign_change(guess, 1e-3 * speed, moment)?;
    let tolerance = TOLERANCE * (speed + guess.abs());
    let (low, high) = root_bracket("the sticking push", low, high, tolerance, moment)?;
    let share = if high.1 > low.1 { low.1 / (low.1 - high.1) } else { 0.0 };
    let twist = twist_at(low.0 + share * (high.0 - low.0));
    let (middle, half) = match surface.wrenches(&twist)? {
        WrenchSet::Disc { center, at, radius } => {
            let arm = at - push.p_sc;
            let along = arm.normalize();
            let left_over = (center - *external_s).shifted(&push.p_sc).torque;
            let across = (-left_over / arm.norm()).clamp(-radius, radius);
            let middle = center.force + across * perpendicular(&along);
            (middle, (radius * radius - across * across).sqrt() * along)
        }
        WrenchSet::Point(_) => {
            let below = surface.wrench(&twist_at(low.0))?.force;
            let change = surface.wrench(&twist_at(high.0))?.force - below;
            (below + share * change, (share * (1.0 - share)).sqrt() * perpendicular(&change))
        }
    };
    Ok((twist, force_in_cone(push, middle - external_s.force, half)))
}

/// Two samples between which an increasing function changes its sign; one of them twice at a root.
fn sign_change(
    guess: f64,
    step: f64,
    function: impl Fn(f64) -> Result<f64, MechanicsError>,
) -> Result<(Sample, Sample), MechanicsError> {
    let mut near = (guess, function(guess)?);
    if near.1 == 0.0 {
        return Ok((near, near));
    }
    let mut reach = -near.1.signum() * step;
    for _ in 0..MAX_DOUBLINGS {
        let far = (guess + reach, function(guess + reach)?);
        if far.1 == 0.0 || (far.1 > 0.0) != (near.1 > 0.0) {
            return Ok(if near.0 < far.0 { (near, far) } else { (far, near) });
        }
        near = far;
        reach *= 2.0;
    }
    Err(MechanicsError::NotConverged {
        what: "the bracket of the sticking push",
        iterations: MAX_DOUBLINGS,
        residual: near.1.abs(),
        tolerance: 0.0,
    })
}

/// Of the forces `middle` + τ `half`, |τ| ≤ 1, the one in the friction cone with the smallest |τ|.
fn force_in_cone(push: &Push, middle: Vector2<f64>, half: Vector2<f64>) -> Vector2<f64> {
    let (mut least, mut most) = (-1.0_f64, 1.0_f64);
    for side in [1.0, -1.0] {
        let inward = push.friction * push.normal_s.into_inner() + side * push.tangent_s();
        let (value, slope) = (inward.dot(&middle), inward.dot(&half));
        if slope > 0.0 {
            least = least.max(-value / slope);
        } else if slope < 0.0 {
            most = most.min(-value / slope);
        }
    }
    if least <= most { middle + 0.0_f64.clamp(least, most) * half } else { middle }
}
