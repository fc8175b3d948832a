//! A rig, its effects and a step go in, all channels of the step come out.

pub(crate) mod area_friction;
pub(crate) mod at_rest;
pub(crate) mod balance;
pub(crate) mod contact_event;
pub(crate) mod forward;
pub(crate) mod friction;
pub(crate) mod friction_in_force;
pub(crate) mod holding;
pub(crate) mod inertia;
pub(crate) mod instant;
pub(crate) mod lean;
pub(crate) mod moved;
pub(crate) mod parts;
pub(crate) mod path;
pub(crate) mod press;
pub(crate) mod push_physics;
pub(crate) mod run_up;
pub(crate) mod substep_end;
pub(crate) mod touch_time;

use nalgebra::Vector2;

use crate::predict::forward::Forward;
use crate::predict::instant::ForceBalance;
use crate::predict::push_physics::Differing;
use crate::{Channels, EffectError, PushPhysics, StepInput, deviations};

/// The channels of a step over pushes.
#[derive(Clone, Debug, PartialEq)]
pub struct Predicted {
    /// Expected.
    pub mean: Channels,
    /// Deviations of pushes, [`Channels::to_array`]: the covariance over pushes is the sum of their squares.
    /// None where all pushes are the same.
    pub deviations: Vec<[f64; 7]>,
}

impl PushPhysics {
    /// All channels of one step, expected where parameters differ from push to push or from place to place.
    ///
    /// The push is integrated along the pusher's path by the midpoint rule, in as many sub-steps of
    /// equal time as the path has millimeters (four or more) and cut where the pusher turns back, its
    /// velocity jumps or it touches: within 4 µm of the exact push over 4 mm, and within 50 µm over a
    /// whole push of 50 mm that begins before the touch, passes a vertex or slides off. With inertia the motion follows an L-stable
    /// Runge–Kutta rule of order two in sub-steps twice as long, three or more.
    ///
    /// # Errors
    /// `InvalidValue` for a step, an object or effects with impossible numbers, or a path of more
    /// than 100 000 sub-steps; `OutOfRange` for values that the object or the pusher does not allow; `SlidesByItself` where the object has to rest, or a push of it begins, under a
    /// load that friction cannot hold, and where the pusher cannot hold it either later on; `NotFinite` for numbers that overflow; a solver that did not
    /// converge.
    pub fn predict(&self, step: &StepInput) -> Result<Channels, EffectError> {
        let Predicted { mean, .. } = self.predict_over_pushes(step)?;
        Ok(mean)
    }

    /// The expected channels of one step, and what pushes differ by of them: one more prediction for certain
    /// values of each parameter that differs, the same for every step.
    ///
    /// # Errors
    /// As [`PushPhysics::predict`].
    pub fn predict_over_pushes(&self, step: &StepInput) -> Result<Predicted, EffectError> {
        let differing = self.differing();
        if differing.is_empty() {
            return Ok(Predicted { mean: self.predict_one(step)?, deviations: Vec::new() });
        }
        let places = deviations(differing.len());
        let one = |(weight, numbers): &(f64, Vec<f64>)| {
            let there = self.deviating(&differing, numbers, step).predict_one(step)?;
            Ok((*weight, there.to_array(), share_of_push(&differing, numbers)))
        };
        let all: Vec<_> = places.iter().map(one).collect::<Result<_, EffectError>>()?;
        let mean: [f64; 7] =
            std::array::from_fn(|k| all.iter().map(|(weight, of, _)| weight * of[k]).sum());
        let deviation = |(weight, of, share): (f64, [f64; 7], f64)| {
            let root = (weight * share).sqrt();
            std::array::from_fn(|k| root * (of[k] - mean[k]))
        };
        let deviations = match self.n_drawn() {
            0 => Vec::new(),
            _ => all.into_iter().map(deviation).collect(),
        };
        Ok(Predicted { mean: Channels::from_array(mean), deviations })
    }

    /// The model of a push in the middle of all: what differs from push to push or from place to place has its value of
    /// the model; none where nothing differs.
    pub fn of_typical_push(&self) -> Option<Self> {
        if self.differing().is_empty() {
            return None;
        }
        let mut typical = self.clone();
        typical.per_push.clear();
        typical.per_place.clear();
        Some(typical)
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
        Ok((balance.center, balance.length()))
    }

    /// All channels of many steps, in their order.
    ///
    /// # Errors
    /// The first error of [`PushPhysics::predict`].
    pub fn predict_all(&self, steps: &[StepInput]) -> Result<Vec<Channels>, EffectError> {
        steps.iter().map(|step| self.predict(step)).collect()
    }
}

/// Share of a deviation that a push keeps: that of the parameter that deviates, or of all in the middle.
fn share_of_push(differing: &[Differing], numbers: &[f64]) -> f64 {
    let square: f64 = numbers.iter().map(|number| number * number).sum();
    let pairs = || differing.iter().zip(numbers);
    match square > 0.0 {
        true => {
            pairs().map(|(one, number)| one.share_of_push * number * number).sum::<f64>() / square
        }
        false => pairs().map(|(one, _)| one.share_of_push).sum::<f64>() / numbers.len() as f64,
    }
}
