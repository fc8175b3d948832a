#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod ellipsoid;
mod error;
mod general_push;
mod limit_surface;
mod push;
mod quadric_push;
mod root;

pub use ellipsoid::Ellipsoid;
pub use error::MechanicsError;
pub use general_push::predict_under;
pub use limit_surface::{LimitSurface, WrenchSet};
pub use push::{ContactMode, Push, PushMotion, predict};
