//! What the models obey, from outside the crate.

#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

mod effects;
mod estimation;
mod fast_roll_out;
mod known_steps;
mod laws;
mod orthogonal_discrepancy;
mod per_push;
mod schema;
mod several_shapes;
mod true_outline;
mod watched;
mod without_particles;
