//! Logs in, tables out, from outside the crate.

#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

mod bad_input;
mod bad_tables;
mod damage;
mod dirt;
mod fixtures;
mod limits;
mod made;
mod manual;
mod misread;
mod own_format;
mod parts;
mod several_pushes;
mod steps;
mod whole_pushes;
