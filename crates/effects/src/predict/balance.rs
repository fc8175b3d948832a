//! The motion in which friction, the pusher, other loads and inertia balance.

use mechanics::{ContactMode, Ellipsoid, Push, predict};
use nalgebra::{Matrix2, Matrix3, UnitVector2, Vector2, Vector3};
use planar::perpendicular;

use crate::object::points::Load;
use crate::predict::friction::Friction;
use crate::{ContactLaw, EffectError};

/// All loads of one moment but the pusher's, per unit of the largest friction force, about S.
pub(crate) struct Balance<'a> {
    /// Friction with the table; none in an impact, where it adds nothing.
    pub(crate) friction: Option<&'a Friction<'a>>,
    /// Length that makes turns and velocities, moments and forces of like size, in m.
    pub(crate) length: f64,
    /// What else acts on the object.
    pub(crate) external: Vector3<f64>,
    /// Inertia over the time step, and the motion from which it pulls.
    pub(crate) inertia: Option<(Matrix3<f64>, Vector3<f64>)>,
}

/// One contact, about S in the axes of the outline.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactKinematics {
    /// Where the pusher touches: no motion goes through it.
    pub(crate) point: Vector2<f64>,
    /// Where its force acts.
    pub(crate) acting: Vector2<f64>,
    pub(crate) normal: Vector2<f64>,
    /// The pusher's velocity, in m/s.
    pub(crate) velocity: Vector2<f64>,
}

/// Motion and contact force that belong together.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ContactSolution {
    pub(crate) mode: ContactMode,
    /// (vx, vy, ω) at S.
    pub(crate) motion: Vector3<f64>,
    /// Contact force on the object, per unit of the largest friction force.
    pub(crate) force: Vector2<f64>,
}

impl ContactSolution {
    /// No push, no motion.
    pub(crate) const AT_REST: Self = Self {
        mode: ContactMode::Separated,
        motion: Vector3::new(0.0, 0.0, 0.0),
        force: Vector2::new(0.0, 0.0),
    };
}

const MAX_ITERATIONS: usize = 100;
/// Relative change of the motion at which a search ends.
const TOLERANCE: f64 = 1e-12;
/// After a step of Newton's method that is shorter than this share of the speed the load is known to
/// about its square, without being worked out again.
const SHORT: f64 = 1e-5;

/// The push in closed form on an ellipsoid, with a friction cone that need not be even.
pub(crate) fn closed_form(
    surface: &Ellipsoid,
    touch: &ContactKinematics,
    law: &ContactLaw,
) -> Result<ContactSolution, EffectError> {
    // A cone of the larger half-width tells on which side the force is.
    let wide = law.static_ratio * law.sliding(1.0).max(law.sliding(-1.0));
    let push = touch.push(wide);
    let motion = predict(surface, &push)?;
    let (normal, tangential) = touch.split(&motion.force_s);
    if motion.mode == ContactMode::Separated {
        return Ok(ContactSolution::AT_REST);
    }
    let fits = motion.mode == ContactMode::Sticking && law.sticks(normal, tangential);
    let side = tangential.signum();
    let motion = if fits || law.sliding(side) == wide {
        motion
    } else {
        predict(surface, &touch.push(law.sliding(side)))?
    };
    Ok(ContactSolution {
        mode: motion.mode,
        motion: motion.twist_ws_s.to_vector(),
        force: motion.force_s,
    })
}

impl ContactKinematics {
    fn push(&self, friction: f64) -> Push {
        let normal_s = UnitVector2::new_unchecked(self.normal);
        Push { p_sc: self.point, normal_s, v_wp_s: self.velocity, friction }
    }

    /// Speed at which the pusher approaches the object at rest, in m/s.
    pub(crate) fn approach(&self) -> f64 {
        self.normal.dot(&self.velocity)
    }

    pub(crate) fn tangent(&self) -> Vector2<f64> {
        perpendicular(&self.normal)
    }

    /// Normal and tangential part of a force.
    pub(crate) fn split(&self, force: &Vector2<f64>) -> (f64, f64) {
        (self.normal.dot(force), self.tangent().dot(force))
    }

    /// Slip of a motion: velocity of the pusher over the object along the tangent, in m/s.
    pub(crate) fn slip(&self, motion: &Vector3<f64>) -> f64 {
        let at_contact = motion.xy() + motion.z * perpendicular(&self.point);
        self.tangent().dot(&(self.velocity - at_contact))
    }

    /// The motion of a turn ω with the contact point at the velocity v − slip · tangent.
    fn motion(&self, omega: f64, slip: f64) -> Vector3<f64> {
        let linear = self.velocity - slip * self.tangent() - omega * perpendicular(&self.point);
        Vector3::new(linear.x, linear.y, omega)
    }

    /// How a motion changes with ω.
    fn turn(&self) -> Vector3<f64> {
        Vector3::new(self.point.y, -self.point.x, 1.0)
    }

    /// Maps a load to its moment about the point where the force acts.
    fn lever(&self) -> Vector3<f64> {
        Vector3::new(self.acting.y, -self.acting.x, 1.0)
    }
}

impl Balance<'_> {
    /// The load that the pusher has to bear for a motion.
    pub(crate) fn missing(&self, motion: &Vector3<f64>) -> Result<Load, EffectError> {
        let (mut load, mut slope) = match self.friction {
            Some(friction) => friction.load(motion)?,
            None => (Vector3::zeros(), Matrix3::zeros()),
        };
        load -= self.external;
        if let Some((mass, target)) = &self.inertia {
            load += mass * (motion - target);
            slope += mass;
        }
        Ok((load, slope))
    }

    /// The motion while the pusher touches and moves on; `guess` starts the search.
    ///
    /// A contact that would have to pull is separated, and its motion without meaning.
    pub(crate) fn touched(
        &self,
        touch: &ContactKinematics,
        law: &ContactLaw,
        guess: &ContactSolution,
    ) -> Result<ContactSolution, EffectError> {
        // What slides goes on sliding while it can, though it might stick by now.
        let edge = Edge::new(touch, law, guess.mode);
        if is_sliding(guess.mode)
            && !law.holds(edge.side)
            && let Some(answer) = self.slide_on(touch, &edge, guess)?
            && answer.mode == guess.mode
            && edge.side * touch.slip(&answer.motion) > 0.0
        {
            return Ok(answer);
        }
        let (motion, force) = self.stick(touch, 0.0, guess.motion.z)?;
        let (normal, tangential) = touch.split(&force);
        if law.sticks(normal, tangential) {
            return Ok(ContactSolution { mode: ContactMode::Sticking, motion, force });
        }
        let mode = match tangential >= 0.0 {
            true => ContactMode::SlidingLeft,
            false => ContactMode::SlidingRight,
        };
        let guess =
            if guess.mode == mode { *guess } else { ContactSolution { mode, motion, force } };
        let edge = Edge::new(touch, law, mode);
        match self.slide_by_newton(touch, &edge, &guess)? {
            Some(answer) => Ok(answer),
            None => self.slide_by_bracket(touch, &edge, guess.motion.z),
        }
    }

    /// The turn for which the moment about the contact vanishes, at a given slip.
    ///
    /// The moment grows with ω, because the dissipation is convex: Newton's method within a bracket.
    fn stick(
        &self,
        touch: &ContactKinematics,
        slip: f64,
        guess: f64,
    ) -> Result<(Vector3<f64>, Vector2<f64>), EffectError> {
        let (turn, lever) = (touch.turn(), touch.lever());
        let rate = self.speed(touch) / self.length;
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        let (mut omega, mut reach, mut last) = (guess, 0.1 * rate.max(guess.abs()), f64::INFINITY);
        for _ in 0..MAX_ITERATIONS {
            let motion = touch.motion(omega, slip);
            let (load, slope) = self.missing(&motion)?;
            let (moment, change) = (lever.dot(&load), lever.dot(&(slope * turn)));
            let end = if moment > 0.0 { &mut high } else { &mut low };
            *end = omega;
            let mut next = omega - moment / change;
            let shrinks = (next - omega).abs() <= 0.5 * last;
            let is_newton = next > low && next < high && shrinks;
            if !is_newton {
                next = if low.is_finite() && high.is_finite() {
                    0.5 * (low + high)
                } else {
                    reach *= 2.0;
                    omega - moment.signum() * reach
                };
            }
            last = (next - omega).abs();
            let size = rate + omega.abs();
            if is_newton && last <= SHORT * size {
                let load = load + (next - omega) * (slope * turn);
                return Ok((touch.motion(next, slip), load.xy()));
            }
            if moment == 0.0 || high - low <= TOLERANCE * size {
                return Ok((motion, load.xy()));
            }
            omega = next;
        }
        Err(EffectError::NotConverged { what: "the sticking push", iterations: MAX_ITERATIONS })
    }

    /// The sliding that goes on, near a guess; where friction falls with the slip, also below the one that the least
    /// friction would leave.
    fn slide_on(
        &self,
        touch: &ContactKinematics,
        edge: &Edge<'_>,
        guess: &ContactSolution,
    ) -> Result<Option<ContactSolution>, EffectError> {
        let near = self.slide_by_newton(touch, edge, guess)?;
        if near.is_some() || edge.law.static_ratio == 1.0 {
            return Ok(near);
        }
        let least = ContactLaw { static_ratio: 1.0, ..*edge.law };
        let fastest = self.slide_by_newton(touch, &Edge::new(touch, &least, edge.mode), guess)?;
        match fastest {
            Some(fastest) => self.slide_by_newton(touch, edge, &fastest),
            None => Ok(None),
        }
    }

    /// The turn and the slip for which the force is on the cone's edge; none where steps grow, and where friction
    /// falls with the slip by more than the load does: no contact slides so for long.
    fn slide_by_newton(
        &self,
        touch: &ContactKinematics,
        edge: &Edge<'_>,
        guess: &ContactSolution,
    ) -> Result<Option<ContactSolution>, EffectError> {
        let (turn, tangent) = (touch.turn() / self.length, touch.tangent());
        let lever = touch.lever() / self.length;
        let along = Vector3::new(-tangent.x, -tangent.y, 0.0);
        let speed = self.speed(touch);
        let slip = edge.side * touch.slip(&guess.motion);
        let slip = edge.side * if slip > 0.0 { slip } else { 0.1 * speed };
        // Turn times length, and slip, in m/s.
        let mut at = Vector2::new(self.length * guess.motion.z, slip);
        let mut last = f64::INFINITY;
        for _ in 0..MAX_ITERATIONS / 4 {
            let motion = touch.motion(at.x / self.length, at.y);
            let (load, slope) = self.missing(&motion)?;
            let (outside, outside_by_slip) = edge.outside(at.y);
            let more = outside_by_slip.dot(&load.xy());
            let outside = Vector3::new(outside.x, outside.y, 0.0);
            let residual = Vector2::new(lever.dot(&load), outside.dot(&load));
            let (by_turn, by_slip) = (slope * turn, slope * along);
            let jacobian = Matrix2::new(
                lever.dot(&by_turn),
                lever.dot(&by_slip),
                outside.dot(&by_turn),
                outside.dot(&by_slip) + more,
            );
            let Some(inverse) = jacobian.try_inverse() else { return Ok(None) };
            let step = inverse * residual;
            if step.norm() <= SHORT * speed {
                if more != 0.0 && jacobian.determinant() * jacobian.m11 >= 0.0 {
                    return Ok(None);
                }
                let end = at - step;
                let end = touch.motion(end.x / self.length, end.y);
                let load = load + slope * (end - motion);
                return Ok(Some(edge.answer(touch, end, load.xy())));
            }
            if !(residual.norm() < 2.0 * last && step.norm() < 10.0 * speed) {
                return Ok(None);
            }
            last = residual.norm();
            at -= step;
        }
        Ok(None)
    }

    /// The same by the sticking solution at each slip: the force turns one way as the slip grows.
    fn slide_by_bracket(
        &self,
        touch: &ContactKinematics,
        edge: &Edge<'_>,
        guess: f64,
    ) -> Result<ContactSolution, EffectError> {
        let speed = self.speed(touch);
        let (mut low, mut high) = (0.0, 0.25 * speed);
        let excess = |slip: f64, guess: f64| {
            let (motion, force) = self.stick(touch, edge.side * slip, guess)?;
            Ok::<_, EffectError>((
                edge.side * edge.outside(edge.side * slip).0.dot(&force),
                motion,
                force,
            ))
        };
        let mut omega = guess;
        for _ in 0..MAX_ITERATIONS {
            let (value, motion, _) = excess(high, omega)?;
            omega = motion.z;
            if value <= 0.0 {
                break;
            }
            (low, high) = (high, 2.0 * high);
        }
        for _ in 0..2 * MAX_ITERATIONS {
            let middle = 0.5 * (low + high);
            let (value, motion, force) = excess(middle, omega)?;
            omega = motion.z;
            if high - low <= TOLERANCE * speed || value == 0.0 {
                return Ok(edge.answer(touch, motion, force));
            }
            if value > 0.0 {
                low = middle
            } else {
                high = middle
            }
            // From nearer to the answer Newton's method may find it.
            let guess = ContactSolution { mode: edge.mode, motion, force };
            if let Some(answer) = self.slide_by_newton(touch, edge, &guess)?
                && (low..=high).contains(&(edge.side * touch.slip(&answer.motion)))
            {
                return Ok(answer);
            }
        }
        Err(EffectError::NotConverged { what: "the sliding push", iterations: 2 * MAX_ITERATIONS })
    }

    /// The size of velocities: the pusher's, or that of an object which is faster, in m/s.
    fn speed(&self, touch: &ContactKinematics) -> f64 {
        let pull = self
            .inertia
            .map_or(0.0, |(_, target)| target.xy().norm().max(self.length * target.z.abs()));
        touch.velocity.norm().max(pull).max(f64::MIN_POSITIVE)
    }
}

/// An edge of the friction cone.
struct Edge<'a> {
    mode: ContactMode,
    /// +1 for the left edge, −1 for the right.
    side: f64,
    touch: &'a ContactKinematics,
    law: &'a ContactLaw,
}

impl<'a> Edge<'a> {
    /// The edge on which the force of a sliding `mode` is.
    fn new(touch: &'a ContactKinematics, law: &'a ContactLaw, mode: ContactMode) -> Self {
        let side = if mode == ContactMode::SlidingLeft { 1.0 } else { -1.0 };
        Self { mode, side, touch, law }
    }

    /// Normal to the edge at some slip, out of the cone on the left, into it on the right, and its
    /// derivative by the slip.
    fn outside(&self, slip: f64) -> (Vector2<f64>, Vector2<f64>) {
        let (friction, by_slip) = self.law.slipping(self.side, slip);
        let normal = self.touch.normal;
        (self.touch.tangent() - self.side * friction * normal, -by_slip * normal)
    }

    /// A solution with its force on the edge, or on the edge's other side of the contact: separated.
    fn answer(
        &self,
        touch: &ContactKinematics,
        motion: Vector3<f64>,
        force: Vector2<f64>,
    ) -> ContactSolution {
        let pushes = touch.normal.dot(&force) > 0.0;
        ContactSolution {
            mode: if pushes { self.mode } else { ContactMode::Separated },
            motion,
            force,
        }
    }
}

pub(crate) fn is_sliding(mode: ContactMode) -> bool {
    matches!(mode, ContactMode::SlidingLeft | ContactMode::SlidingRight)
}
