//! What written files and folders obey, from outside the crate.

#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

mod laws;
