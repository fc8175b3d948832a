#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod ellipsoid;
mod error;
mod fit;
mod limit_surface;
mod mesh;
mod patch;
mod point_set;
mod polar;
mod quadrature;
mod quartic;
mod single_point;
mod uniform_patch;

pub use ellipsoid::Ellipsoid;
pub use error::MechanicsError;
pub use fit::{Fit, WrenchTwist, fit_ellipsoid, fit_patch, fit_quartic, scored};
pub use limit_surface::{LimitSurface, WrenchSet};
pub use mesh::{Mesh, mesh};
pub use patch::Patch;
pub use point_set::{Facet, PointSet};
pub use quartic::{QUARTIC_EXPONENTS, Quartic};
pub use single_point::SinglePoint;
