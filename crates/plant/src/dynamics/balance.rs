//! The balance of forces at the end of an implicit step, and the motion that fulfils it.

use libm::sqrt;
use nalgebra::{Matrix2, Matrix3, Vector3};

use crate::dynamics::resistance::Footing;
use crate::dynamics::tip_contact::{Response, TipContact};
use crate::truth::RateLaw;

const MAX_ITERATIONS: usize = 40;
const MAX_HALVINGS: usize = 14;

/// Inertia, friction, contact and external load of one step, in the body's axes.
pub(crate) struct Balance<'a> {
    pub(crate) footing: &'a Footing,
    /// Largest friction of each pad, in N.
    pub(crate) frictions: &'a [f64],
    pub(crate) metric: Matrix2<f64>,
    pub(crate) creep: f64,
    pub(crate) rate: &'a RateLaw,
    pub(crate) contact: TipContact,
    /// Force and moment of all else, in N and N·m.
    pub(crate) external: Vector3<f64>,
    /// Motion at the beginning of the step.
    pub(crate) start: Vector3<f64>,
    /// Mass, mass and moment of inertia over the step's length.
    pub(crate) inertia: Vector3<f64>,
    /// Length that makes moments comparable to forces, in m.
    pub(crate) arm: f64,
    /// Force that may be left over, in N.
    pub(crate) goal: f64,
}

/// The motion at the end of a step.
pub(crate) struct Solved {
    /// (vx, vy, ω), in m/s and rad/s.
    pub(crate) motion: Vector3<f64>,
    /// Load of friction, opposite to what it exerts.
    pub(crate) support: Vector3<f64>,
    pub(crate) response: Response,
}

/// What is left over with some motion.
struct Trial {
    solved: Solved,
    left_over: Vector3<f64>,
    slope: Matrix3<f64>,
    size: f64,
}

/// An object is at rest where it moves slower than so many times the creep speed, and friction bears
/// what acts on it with no more of it: below 97 % of its limit.
const REST: f64 = 4.0;

impl Balance<'_> {
    /// Whether the object rests under a load: the tip does not push it, friction bears all else, and it
    /// moves no faster than it creeps under that.
    ///
    /// Rounded friction alone would let it creep on for ever; without any load it stops it by itself.
    pub(crate) fn rests(&self) -> bool {
        self.external != Vector3::zeros()
            && self.speed(&self.start) <= REST * self.creep
            && self.contact.response(&Vector3::zeros()).load == Vector3::zeros()
            && self.external_is_borne()
    }

    /// The balance of an object that stays where it is.
    pub(crate) fn resting(&self) -> Solved {
        let motion = Vector3::zeros();
        Solved { motion, support: self.external, response: self.contact.response(&motion) }
    }

    /// Whether friction balances the external load at a speed of creeping, by Newton's method.
    fn external_is_borne(&self) -> bool {
        let mut motion = Vector3::zeros();
        for _ in 0..MAX_ITERATIONS {
            let friction = self.footing.resistance(
                self.frictions,
                &motion,
                &self.metric,
                self.creep,
                self.rate,
            );
            let left_over = friction.load - self.external;
            if self.size(&left_over) <= self.goal {
                return true;
            }
            let Some(inverse) = friction.slope.try_inverse() else { return false };
            motion -= inverse * left_over;
            // The slope falls with the speed, so that the method comes from below.
            let is_slow = self.speed(&motion) <= REST * self.creep;
            if !is_slow {
                return false;
            }
        }
        false
    }

    /// Size of a motion, turns by the speed of the outline, in m/s.
    fn speed(&self, motion: &Vector3<f64>) -> f64 {
        let turn = self.arm * motion.z;
        sqrt(motion.x * motion.x + motion.y * motion.y + turn * turn)
    }

    /// Size of a force and moment, in N.
    fn size(&self, load: &Vector3<f64>) -> f64 {
        let moment = load.z / self.arm;
        sqrt(load.x * load.x + load.y * load.y + moment * moment)
    }

    /// The motion under which no force is left over, by Newton's method from the last motion.
    ///
    /// Steps are halved until less is left over: friction has kinks that a whole step may overshoot.
    ///
    /// # Errors
    /// What did not converge.
    pub(crate) fn solve(&self) -> Result<Solved, &'static str> {
        let mut now = self.trial(self.start);
        for _ in 0..MAX_ITERATIONS {
            if now.size <= self.goal {
                return Ok(now.solved);
            }
            let inverse = now.slope.try_inverse().ok_or("a singular balance of forces")?;
            let direction = inverse * now.left_over;
            now = self.better(&now, &direction).ok_or("the balance of forces gets no better")?;
        }
        Err("the balance of forces takes too many iterations")
    }

    /// The longest of the steps 1, 1/2, 1/4, … with less left over.
    fn better(&self, now: &Trial, direction: &Vector3<f64>) -> Option<Trial> {
        let mut share = 1.0;
        for _ in 0..=MAX_HALVINGS {
            let next = self.trial(now.solved.motion - share * direction);
            if next.size < (1.0 - 1e-4 * share) * now.size {
                return Some(next);
            }
            share *= 0.5;
        }
        None
    }

    fn trial(&self, motion: Vector3<f64>) -> Trial {
        let support =
            self.footing.resistance(self.frictions, &motion, &self.metric, self.creep, self.rate);
        let response = self.contact.response(&motion);
        let inertial = self.inertia.component_mul(&(motion - self.start));
        let left_over = inertial + support.load - response.load - self.external;
        Trial {
            left_over,
            slope: Matrix3::from_diagonal(&self.inertia) + support.slope + response.slope,
            size: self.size(&left_over),
            solved: Solved { motion, support: support.load, response },
        }
    }
}
