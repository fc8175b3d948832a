#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod ellipsoid;
mod error;
mod limit_surface;

pub use ellipsoid::Ellipsoid;
pub use error::MechanicsError;
pub use limit_surface::{LimitSurface, WrenchSet};
