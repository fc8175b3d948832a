#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod ellipsoid;
mod error;
mod general_push;
mod limit_surface;
mod path;
mod path_motion;
mod path_push;
mod push;
mod quadric_push;
mod root;
mod runge_kutta;
mod slider;

pub use ellipsoid::Ellipsoid;
pub use error::MechanicsError;
pub use general_push::predict_under;
pub use limit_surface::{LimitSurface, WrenchSet};
pub use path::{Polyline, PusherPath, SmoothPath, StraightPath};
pub use path_motion::{ContactPhase, PathMotion, PathSample, PathSettings, Place};
pub use path_push::push_along;
pub use push::{ContactMode, Push, PushMotion, predict};
pub use slider::{Pusher, Slider};
