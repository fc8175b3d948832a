//! A model and observed steps go in, its predictions come out, with their slopes by all that may
//! move them, and whole pushes.

pub(crate) mod candidates;
pub(crate) mod error_shapes;
pub(crate) mod predictions;
pub(crate) mod push_ends;
pub(crate) mod rollout;
pub(crate) mod secants;
pub(crate) mod tangent;
