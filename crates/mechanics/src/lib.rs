#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod ellipsoid;
mod error;
mod fit;
mod friction_cone;
mod general_push;
mod joint_push;
mod limit_surface;
mod mesh;
mod motion_cone;
mod patch;
mod path;
mod path_motion;
mod path_push;
mod point_set;
mod polar;
mod push;
mod quadratic_patch;
mod quadrature;
mod quadric_push;
mod quartic;
mod root;
mod rotation;
mod runge_kutta;
mod single_point;
mod slider;

pub use ellipsoid::Ellipsoid;
pub use error::MechanicsError;
pub use fit::{Fit, WrenchTwist, fit_ellipsoid, fit_patch, fit_quartic, scored};
pub use friction_cone::FrictionCone;
pub use general_push::predict_under;
pub use joint_push::predict_joint;
pub use limit_surface::{LimitSurface, WrenchSet};
pub use mesh::{Mesh, mesh};
pub use motion_cone::MotionCone;
pub use patch::Patch;
pub use path::{Polyline, PusherPath, SmoothPath, StraightPath};
pub use path_motion::{ContactPhase, PathMotion, PathSample, PathSettings, Place};
pub use path_push::{push_along, push_along_under};
pub use point_set::{Facet, PointSet};
pub use push::{ContactMode, Push, PushMotion, predict};
pub use quadratic_patch::QuadraticTraction;
pub use quartic::{QUARTIC_EXPONENTS, Quartic};
pub use rotation::{CenterOfRotation, Sense, sense_of_rotation};
pub use single_point::SinglePoint;
pub use slider::{Pusher, Slider};
