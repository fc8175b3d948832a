#![doc = include_str!("../README.md")]

mod contact;
mod ellipse;
mod error;
mod mit_names;
mod mit_object;
mod polygon;
mod pose;
mod shape;
mod triangulation;
mod twist;
mod vector_space;
mod wrench;

pub use contact::{Contact, Feature};
pub use ellipse::{Ellipse, GAUSS_LEGENDRE};
pub use error::PlanarError;
pub use mit_names::MIT_NAMES;
pub use mit_object::{MitObject, mit_object};
pub use polygon::Polygon;
pub use pose::{Pose, wrap_angle};
pub use shape::Shape;
pub use twist::{Twist, cross, perpendicular};
pub use wrench::Wrench;
