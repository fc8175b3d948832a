#![doc = include_str!("../README.md")]

mod error;
mod file;
mod folder;
mod lock;
mod place;

pub use error::OutputError;
pub use file::{OutputFile, write};
pub use folder::{OutputFolder, PartFolder};
pub use place::Existing;
