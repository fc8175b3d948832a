//! What comparisons, splits and screens obey, from outside the crate.

#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

mod own_effect;
mod rollout;
mod screen_laws;
mod split;
