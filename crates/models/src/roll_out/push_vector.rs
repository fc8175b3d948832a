//! The state of a push as a vector, for Gaussian filters and smoothers of any kind.

use filter::{FilterError, Gaussian, PlanarSummary};
use nalgebra::{DMatrix, DVector};
use planar::Pose;

use super::push_state::{N_POSE, N_STATES, SHARED};
use super::{PushParticle, RollOut, StepErrors};
use crate::{ModelError, PathStep, PushPath};

/// A push as Gaussians have it: a state of seven numbers, and what a step makes of each.
///
/// The state is x and y in m, the angle in rad, the gap that contact holds beyond the nominal one in m, and
/// three numbers that neighboring steps share ([`StepErrors::Held`]; they are 0 else). A filter is what
/// carries a Gaussian by [`PushVector::after`] and updates it by measurements: [`Gaussian::predicted_by`] by
/// a rule's points, [`Gaussian::predicted`] by the slopes at the mean, [`filter::rauch_tung_striebel`] back.
/// Ways that a contact may go are one Gaussian here; see [`RollOut::matched`] for several.
pub struct PushVector<'a> {
    roll_out: RollOut<'a>,
    /// The push's start, of which all states are copies.
    first: PushParticle,
    start_wb: Pose,
    /// The mean square of a push's size.
    size: f64,
}

impl<'a> PushVector<'a> {
    /// Of a push along a path.
    ///
    /// # Errors
    /// As [`RollOut::run`]; `NoClosedForm` for a model whose pushes draw numbers, which
    /// [`PushTracker`](crate::PushTracker) has in its state.
    pub fn new(
        roll_out: RollOut<'a>,
        start_wb: &Pose,
        path: &PushPath,
    ) -> Result<Self, ModelError> {
        roll_out.check()?;
        let first = roll_out.first(start_wb, path)?;
        // Of a t with two degrees of freedom or fewer there is no variance.
        let size = match &roll_out.settings.errors {
            StepErrors::Held(correlation) if correlation.freedom > 2.0 => {
                correlation.freedom / (correlation.freedom - 2.0)
            }
            _ => 1.0,
        };
        let first = PushParticle { size: size.sqrt(), ..first };
        Ok(Self { roll_out, first, start_wb: *start_wb, size })
    }

    /// What is known of the state at the start.
    ///
    /// # Errors
    /// `Filter` for a pose that is no number.
    pub fn start(&self) -> Result<Gaussian, ModelError> {
        let held = match self.roll_out.settings.errors {
            StepErrors::Held(_) => self.size,
            StepErrors::None | StepErrors::Independent => 0.0,
        };
        Ok(self.roll_out.start_gaussian(&self.start_wb, held)?)
    }

    /// What a step makes of one state: the likeliest way that it may go, and what the step leaves open.
    ///
    /// # Errors
    /// What the model refuses; `Filter` for a state that is no number.
    pub fn after(&self, step: &PathStep, state: &DVector<f64>) -> Result<Gaussian, ModelError> {
        if state.len() != N_STATES {
            let (what, expected, actual) = ("state of a push", N_STATES, state.len());
            return Err(FilterError::ShapeMismatch { what, expected, actual }.into());
        }
        let motion = self.roll_out.motion(step)?;
        let ways = motion.ways_of_point(&self.first, state)?;
        let best = ways.into_iter().max_by(|(_, a, _), (_, b, _)| a.total_cmp(b));
        let (_, _, moved) = best.ok_or(FilterError::Empty { what: "ways of a state" })?;
        let StepErrors::Held(correlation) = &self.roll_out.settings.errors else {
            return Ok(moved);
        };
        let kept = correlation.kept(step.distance());
        let (mut mean, mut covariance) = (moved.mean().clone(), moved.covariance().clone());
        for k in SHARED {
            mean[k] *= kept;
            covariance[(k, k)] += (1.0 - kept * kept) * self.size;
        }
        Ok(Gaussian::new(mean, covariance)?)
    }

    /// The slopes of [`PushVector::after`]'s mean by the state, by differences of a tenth of a standard
    /// deviation: what the extended Kalman filter takes ([`filter::LinearMotion`]).
    ///
    /// # Errors
    /// As [`PushVector::after`].
    pub fn slopes(&self, step: &PathStep, state: &Gaussian) -> Result<DMatrix<f64>, ModelError> {
        let mut slopes = DMatrix::identity(N_STATES, N_STATES);
        for k in 0..N_STATES {
            let off = DIFFERENCE * state.covariance()[(k, k)].sqrt().max(LEAST);
            let moved = |by: f64| -> Result<DVector<f64>, ModelError> {
                let mut point = state.mean().clone();
                point[k] += by;
                Ok(self.after(step, &point)?.mean().clone())
            };
            slopes.set_column(k, &((moved(off)? - moved(-off)?) / (2.0 * off)));
        }
        Ok(slopes)
    }

    /// The pose of a Gaussian over the state.
    ///
    /// # Errors
    /// `Filter` for one of another dimension.
    pub fn pose(state: &Gaussian) -> Result<PlanarSummary, ModelError> {
        if state.mean().len() != N_STATES {
            let (what, expected, actual) = ("state of a push", N_STATES, state.mean().len());
            return Err(FilterError::ShapeMismatch { what, expected, actual }.into());
        }
        let mean = state.mean().rows(0, N_POSE).into_owned();
        let covariance = state.covariance().view((0, 0), (N_POSE, N_POSE)).into_owned();
        Ok(PlanarSummary::of_gaussian(&Gaussian::new(mean, covariance)?)?)
    }
}

/// In standard deviations: local, and beyond the rounding of the contact.
const DIFFERENCE: f64 = 0.1;
/// A smaller one is none, in m, rad or without unit.
const LEAST: f64 = 1e-6;
