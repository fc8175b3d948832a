//! What sparse processes obey, from outside the crate.

#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

mod bad_input;
mod by_name;
mod grid;
mod laws;
mod learning;
mod means_and_rows;
mod reference;
mod row_noise;
mod stochastic;
mod uncertain_inputs;
