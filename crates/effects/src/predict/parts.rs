//! What is expected of a step, in parts: a typical push, and what each parameter that differs adds.

use crate::{Channels, EffectError, PushPhysics, StepInput, deviations};

/// What is expected of a step where parameters differ from push to push or from place to place.
#[derive(Clone, Debug, PartialEq)]
pub struct PredictedParts {
    /// Of a push in the middle of all.
    pub typical: Channels,
    /// What each parameter that differs adds to it in the mean, [`Channels::to_array`], in the order in which they
    /// act; 0 of those that were not asked for.
    pub added: Vec<[f64; 7]>,
}

impl PredictedParts {
    /// All parts together, [`Channels::to_array`]: what [`PushPhysics::predict`] expects if every parameter was asked
    /// for.
    pub fn sum(&self) -> [f64; 7] {
        let mut sum = self.typical.to_array();
        for added in &self.added {
            sum.iter_mut().zip(added).for_each(|(sum, added)| *sum += added);
        }
        sum
    }
}

impl PushPhysics {
    /// What is expected of one step, in parts: one prediction, and two for each parameter that differs and is asked
    /// for by its index, in the order in which they act (four where a single one differs).
    ///
    /// # Errors
    /// As [`PushPhysics::predict`].
    pub fn predict_parts(
        &self,
        step: &StepInput,
        is_asked: impl Fn(usize) -> bool,
    ) -> Result<PredictedParts, EffectError> {
        let differing = self.differing();
        let numbers = vec![0.0; differing.len()];
        let typical = self.deviating(&differing, &numbers, step).predict_one(step)?;
        let middle = typical.to_array();
        let mut added = vec![[0.0; 7]; differing.len()];
        for (weight, numbers) in deviations(differing.len()) {
            // Each place is on one axis, or in the middle.
            let axis = numbers.iter().position(|number| *number != 0.0);
            if let Some(axis) = axis.filter(|axis| is_asked(*axis)) {
                let there = self.deviating(&differing, &numbers, step).predict_one(step)?;
                let pairs = there.to_array().into_iter().zip(middle);
                let added = added[axis].iter_mut();
                added.zip(pairs).for_each(|(sum, (there, here))| *sum += weight * (there - here));
            }
        }
        Ok(PredictedParts { typical, added })
    }
}
