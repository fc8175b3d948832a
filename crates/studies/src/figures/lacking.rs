//! Data that do not hold what a figure shows.

use std::fmt;

/// Why a figure cannot be drawn: the data lack what it shows.
#[derive(Clone, Debug)]
pub(crate) struct Lacking {
    pub(super) needs: &'static str,
    pub(super) has: String,
}

impl fmt::Display for Lacking {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "needs {}, which are not in {}", self.needs, self.has)
    }
}

impl std::error::Error for Lacking {}
