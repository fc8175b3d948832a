//! How a particle filter resamples, and its seed.

use crate::{FilterError, Resampler, Systematic};

/// Settings of a particle filter.
#[derive(Clone, Copy, Debug)]
pub struct Settings<'a> {
    /// How particles are drawn anew.
    pub resampler: &'a dyn Resampler,
    /// Resample when the effective sample size falls below this share of the particles, from 0
    /// (never) to 1.
    pub resample_below: f64,
    /// Seed of everything random; `random.random()` where any generator gives it.
    pub seed: u64,
}

impl Default for Settings<'_> {
    fn default() -> Self {
        Self { resampler: &Systematic, resample_below: 0.5, seed: 7 }
    }
}

impl Settings<'_> {
    pub(crate) fn check(&self) -> Result<(), FilterError> {
        let value = self.resample_below;
        if (0.0..=1.0).contains(&value) {
            return Ok(());
        }
        Err(FilterError::OutOfRange { name: "resample_below", expected: "from 0 to 1", value })
    }
}
