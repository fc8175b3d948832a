//! What the Gaussian processes obey, from outside the crate.

#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

mod bad_input;
mod builder;
mod gp_laws;
mod heteroscedastic;
mod kernel_laws;
mod learning;
mod learnt_means;
mod linear_regression;
mod means;
mod outputs;
mod reference;
mod rows_and_outputs;
mod scores;
mod shared_inputs;
mod student_t;
mod uncertain_inputs;
