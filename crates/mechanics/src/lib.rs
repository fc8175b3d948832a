#![doc = include_str!("../README.md")]

// From the ground up: what comes first knows nothing of what comes after it.
mod error;

mod numerics;

mod limit_surface;

mod push;

mod path;

pub use {nalgebra, planar};

pub use error::MechanicsError;
pub use limit_surface::fit::{Fit, WrenchTwist, fit_ellipsoid, fit_quartic, scored};
pub use limit_surface::mesh::{Mesh, mesh};
pub use limit_surface::point_set::Facet;
pub use limit_surface::quadratic_patch::QuadraticTraction;
pub use limit_surface::quartic::QUARTIC_EXPONENTS;
pub use limit_surface::uniform::{UniformPressure, UniformSurface};
#[allow(clippy::wildcard_imports)] // The list of surfaces says what is handed on.
pub use limit_surface::*;
pub use path::edge_push::{EdgePush, StraightPush};
pub use path::follow::{push_along, push_along_with_external_wrench};
pub use path::motion::{ContactPhase, PathMotion, PathSample, PathSettings, Place};
pub use path::pusher_path::{Polyline, PusherPath, SmoothPath, StraightPath};
pub use push::contact::{ContactMode, Push, PushMotion};
pub use push::friction_cone::FrictionCone;
pub use push::general::{predict, predict_with_external_wrench};
pub use push::joint::predict_multi_contact;
pub use push::motion_cone::MotionCone;
pub use push::rotation::{CenterOfRotation, Sense, sense_of_rotation};
pub use push::slider::{Pusher, Slider, UniformSupport};
