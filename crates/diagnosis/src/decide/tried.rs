//! An effect tried beside a model.

use crate::DiagnosisError;
use crate::cut_offs::SIZE;
use crate::fit::{Refit, Trial};

/// An effect near its minimum beside a model.
pub(super) struct Tried<'a> {
    pub(super) trial: Trial<'a>,
    /// The model without it, where its nominal value was a nuisance before.
    pub(super) without: Option<Refit<'a>>,
    /// What it changes, over the noise.
    pub(super) size: f64,
}

impl Tried<'_> {
    /// What is minimised, with a price for each number.
    pub(super) fn cost(&self) -> f64 {
        self.trial.objective() + 2.0 * self.trial.freedom as f64
    }

    /// Goes to a lower minimum farther off if the effect is not small there; tells whether it did.
    ///
    /// # Errors
    /// What a prediction refuses.
    pub(super) fn goes_farther(&mut self, here: &Refit) -> Result<bool, DiagnosisError> {
        let mut trial = self.trial.clone();
        trial.look_farther();
        let size = self.without.as_ref().unwrap_or(here).size_of(&trial)?;
        if size >= SIZE {
            (self.trial, self.size) = (trial, size);
        }
        Ok(size >= SIZE)
    }
}
