//! Where randomness begins.

/// The seed of every random stream in the figures.
pub(crate) const SEED: u64 = 7;
