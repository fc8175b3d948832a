//! What the simulated rig obeys, from outside the crate.

mod convergence;
mod effects;
mod push_laws;
mod rig;
mod sets;
mod uneven;
