//! What the figures are drawn from.

/// The seed of every random stream in the figures.
pub(crate) const SEED: u64 = 7;

/// Inputs that several figures share; the figures of mechanics need none.
pub(crate) struct Inputs;
