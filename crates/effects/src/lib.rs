#![doc = include_str!("../README.md")]

// From the ground up: what comes first knows nothing of what comes after it.
mod error;

mod object;

mod step;

mod effect;

mod catalogue;

mod predict;

#[cfg(doctest)]
mod pages;

pub use {mechanics, nalgebra, planar};

pub use catalogue::{
    BodyAnisotropy, ContactBias, EdgeRounding, ForceBias, FrictionCenterOffset, FrictionDrift,
    FrictionGradient, Inertia, LimitSurfaceShape, PoseOffset, PressureRadius, PusherCompliance,
    PusherFriction, PusherFrictionAsymmetry, PusherRadius, PusherStiction, RateDependentFriction,
    StreamLatency, SupportFriction, SupportStiction, TableAnisotropy, TableTilt, YawOffset, all,
    by_id,
};
pub use effect::contact_law::ContactLaw;
pub use effect::geometry::{Geometry, TrueOutline};
pub use effect::parameter::{Coordinate, Frame, Off, Parameter, Role};
pub use effect::reading::MeasurementModel;
pub use effect::setting::Setting;
pub use effect::support::{LogTensor, Support};
pub use effect::{Effect, EffectInfo, LookAlike, Sliding, Snapshot, Stage};
pub use error::EffectError;
pub use object::Object;
pub use predict::push_physics::PushPhysics;
pub use step::channels::{Channel, Channels};
pub use step::input::StepInput;
pub use step::rig::{Rig, Surface};
pub use step::track::Track;
