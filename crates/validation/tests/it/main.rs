//! The whole against simulated recordings.

#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

mod compare_finds_what_is_hidden;
mod fields_of_friction;
mod fits_recover_what_is_hidden;
mod plant_meets_mechanics;
mod recordings_that_contradict_mechanics;
mod rows_without_ids;
mod screen_names_what_is_hidden;
