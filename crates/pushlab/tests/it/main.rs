//! The command-line tool, run as its users run it, and what it says of recordings read wrongly.

#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

mod bad_input;
mod browser;
mod checked;
mod commands;
mod comparison;
mod contradicting;
mod demonstrated;
mod diagnosed;
mod diagnosing;
mod documentation;
mod explored;
mod fitting;
mod generated;
mod inputs;
mod killed;
mod misread_data;
mod other_rig;
mod parted;
mod ran;
mod report_page;
mod schema;
mod simulated;
mod small_set;
mod standard_output;
mod suggested;
mod tracked;
mod trained;
mod usage;
mod whole_pushes;
mod written;
