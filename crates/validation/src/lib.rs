#![doc = include_str!("../README.md")]

pub mod fixtures;
pub mod made_once;
pub mod rig_calibration;
pub mod surface;
pub mod trials;
mod workspace;

pub use workspace::workspace_root;
