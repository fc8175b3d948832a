#![doc = include_str!("../README.md")]

#[cfg(feature = "cli")]
mod command_line;
#[cfg(feature = "cli")]
mod commands;
#[cfg(feature = "cli")]
mod destination;
#[cfg(feature = "cli")]
mod diagnosis_file;
#[cfg(feature = "cli")]
mod document;
#[cfg(feature = "cli")]
mod failure;
#[cfg(feature = "cli")]
mod file_ending;
#[cfg(feature = "cli")]
mod fitting;
#[cfg(feature = "cli")]
mod global;
#[cfg(feature = "cli")]
mod heard;
#[cfg(feature = "cli")]
mod in_process;
#[cfg(feature = "cli")]
mod known;
#[cfg(feature = "cli")]
mod listener;
#[cfg(feature = "cli")]
mod opened;
#[cfg(feature = "cli")]
mod origin;
#[cfg(doctest)]
mod pages;
#[cfg(feature = "cli")]
mod people;
#[cfg(feature = "cli")]
mod program;
#[cfg(feature = "cli")]
mod progress;
#[cfg(feature = "cli")]
mod recorded_steps;
#[cfg(feature = "cli")]
mod rig;
#[cfg(feature = "cli")]
mod some_of;
#[cfg(feature = "cli")]
mod speed;
#[cfg(feature = "cli")]
mod step_kind;
#[cfg(feature = "cli")]
mod step_size;
#[cfg(feature = "cli")]
mod step_source;
#[cfg(feature = "cli")]
mod suspected;
#[cfg(feature = "cli")]
mod table_summary;
#[cfg(feature = "cli")]
mod terminal;
#[cfg(feature = "cli")]
mod unexplained;
#[cfg(feature = "cli")]
mod whole_pushes;
#[cfg(feature = "cli")]
mod wrong_usage;

pub use dataset;
pub use diagnosis;
pub use effects;
pub use filter;
pub use gp_core;
pub use mechanics;
pub use models;
pub use output;
pub use planar;
pub use plant;
pub use report;

#[cfg(feature = "cli")]
pub use in_process::{CommandError, explained, run};
#[cfg(feature = "cli")]
pub use listener::{Listener, Printed};
#[cfg(feature = "cli")]
pub use program::program;
