//! The balance of forces at the end of an implicit step, and the motion that fulfils it.

use libm::sqrt;
use nalgebra::{Matrix2, Matrix3, Vector3};

use crate::resistance::Footing;
use crate::tip_contact::{Response, TipContact};
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

impl Balance<'_> {
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
        let moment = left_over.z / self.arm;
        Trial {
            left_over,
            slope: Matrix3::from_diagonal(&self.inertia) + support.slope + response.slope,
            size: sqrt(left_over.x * left_over.x + left_over.y * left_over.y + moment * moment),
            solved: Solved { motion, support: support.load, response },
        }
    }
}
