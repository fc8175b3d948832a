//! What processes on random features obey, from outside the crate.

#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

mod bad_input;
mod by_name;
mod laws;
mod learning;
mod means_and_noise;
mod uncertain_inputs;
