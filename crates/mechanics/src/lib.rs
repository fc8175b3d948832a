#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod ellipsoid;
mod error;
mod limit_surface;
mod patch;
mod point_set;
mod polar;
mod quadrature;
mod single_point;
mod uniform_patch;

pub use ellipsoid::Ellipsoid;
pub use error::MechanicsError;
pub use limit_surface::{LimitSurface, WrenchSet};
pub use patch::Patch;
pub use point_set::{Facet, PointSet};
pub use single_point::SinglePoint;
