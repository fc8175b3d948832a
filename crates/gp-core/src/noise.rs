//! The noise on the observations of a process.

use crate::GpError;
use crate::checks::{check_not_negative, check_row_noise};

/// The noise on observations: a common variance, and known ones of the rows or none.
#[derive(Clone, Copy)]
pub(crate) struct Noise<'a> {
    pub(crate) common: f64,
    pub(crate) of_rows: &'a [f64],
}

impl Noise<'_> {
    pub(crate) fn of_row(self, i: usize) -> f64 {
        self.common + self.of_rows.get(i).copied().unwrap_or(0.0)
    }

    /// # Errors
    /// `Negative` or `NotFinite` for a variance that is not finite and not negative.
    pub(crate) fn check(self) -> Result<(), GpError> {
        check_not_negative("noise variance", self.common)?;
        check_row_noise(self.of_rows, self.of_rows.len())
    }
}
