//! What the effects obey, one by one and together.

#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

mod allowed;
mod any_values;
mod exact_push;
mod extremes;
mod field;
mod known_answers;
mod laws;
mod run_up;
mod separation;
mod supports;
mod whole_push;
