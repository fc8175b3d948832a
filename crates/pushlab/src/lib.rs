#![doc = include_str!("../README.md")]

#[cfg(doctest)]
mod pages;
#[cfg(feature = "cli")]
mod tool;

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
pub use tool::{CommandError, Listener, Printed, explained, program, run};
