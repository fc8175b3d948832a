//! A rig, its effects and a step go in, all channels of the step come out.

pub(crate) mod area_friction;
pub(crate) mod at_rest;
pub(crate) mod balance;
pub(crate) mod contact_event;
pub(crate) mod forward;
pub(crate) mod friction;
pub(crate) mod holding;
pub(crate) mod inertia;
pub(crate) mod instant;
pub(crate) mod lean;
pub(crate) mod push_physics;
pub(crate) mod substep_end;
pub(crate) mod touch_time;

use nalgebra::Vector2;

use crate::predict::forward::Forward;
use crate::predict::instant::ForceBalance;
use crate::{Channels, EffectError, PushPhysics, StepInput, deviations};

impl PushPhysics {
    /// All channels of one step, expected where parameters differ from push to push.
    ///
    /// The push is integrated along the pusher's path by the midpoint rule, in as many sub-steps of
    /// equal time as the path has millimeters (four or more) and cut where the pusher turns back, its
    /// velocity jumps or it touches: within 4 µm of the exact push over 4 mm, and within 50 µm over a
    /// whole push of 50 mm that begins before the touch, passes a vertex or slides off. With inertia the motion follows an L-stable
    /// Runge–Kutta rule of order two in six sub-steps or more.
    ///
    /// # Errors
    /// `InvalidValue` for a step, an object or effects with impossible numbers, or a path of more
    /// than 100 000 sub-steps; `OutOfRange` for values that the object or the pusher does not allow; `SlidesByItself` where the object has to rest, or be pushed, under a
    /// load that friction cannot hold; `NotFinite` for numbers that overflow; a solver that did not
    /// converge.
    pub fn predict(&self, step: &StepInput) -> Result<Channels, EffectError> {
        if self.n_drawn() == 0 {
            return self.predict_one(step);
        }
        let mut mean = [0.0; 7];
        for (weight, channels) in self.predict_varied(step)? {
            let of = channels.to_array();
            mean.iter_mut().zip(of).for_each(|(mean, of)| *mean += weight * of);
        }
        Ok(Channels::from_array(mean))
    }

    /// The channels of one step for certain values of the parameters that differ from push to push, with
    /// weights that are together 1: their weighted mean and covariance are those over pushes, by as many
    /// predictions. One without such parameters.
    ///
    /// # Errors
    /// As [`PushPhysics::predict`].
    pub fn predict_varied(&self, step: &StepInput) -> Result<Vec<(f64, Channels)>, EffectError> {
        let one = |(weight, numbers): (f64, Vec<f64>)| {
            Ok((weight, self.drawn(&numbers, step).predict_one(step)?))
        };
        deviations(self.n_drawn()).into_iter().map(one).collect()
    }

    fn predict_one(&self, step: &StepInput) -> Result<Channels, EffectError> {
        step.validate()?;
        self.check_in(step)?;
        let spots = self.spots(&step.object)?;
        Forward::new(self, step, spots.as_ref())?.run()
    }

    /// Center of friction, in m, frame of the outline, and characteristic length c, in m, at the start of a
    /// step: of the area, the spots and the effects that move or stretch them, without a lean.
    ///
    /// # Errors
    /// `InvalidValue` for a step, an object or effects with impossible numbers.
    pub fn center_and_length(&self, step: &StepInput) -> Result<(Vector2<f64>, f64), EffectError> {
        step.validate()?;
        self.check_in(step)?;
        let spots = self.spots(&step.object)?;
        let pose_wo = self.measurement(step).pose_bo();
        let none = Vector2::zeros();
        let balance = ForceBalance::new(self, (step, spots.as_ref()), &pose_wo, 0.0, &none)?;
        Ok((*balance.center(), balance.length()))
    }

    /// All channels of many steps, in their order.
    ///
    /// # Errors
    /// The first error of [`PushPhysics::predict`].
    pub fn predict_all(&self, steps: &[StepInput]) -> Result<Vec<Channels>, EffectError> {
        steps.iter().map(|step| self.predict(step)).collect()
    }
}
