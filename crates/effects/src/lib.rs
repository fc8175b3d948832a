#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod balance;
mod catalogue;
mod channels;
mod contact_law;
mod effect;
mod error;
mod forward;
mod friction;
mod geometry;
mod holding;
mod inertia;
mod instant;
mod object;
#[cfg(doctest)]
mod pages;
mod parameter;
mod patch_table;
mod points;
mod pressure;
mod push_physics;
mod reading;
mod rig;
mod setting;
mod step_input;
mod support;
mod touch_time;
mod track;

pub use catalogue::{
    BodyAnisotropy, ContactBias, EdgeRounding, ForceBias, FrictionCenterOffset, FrictionDrift,
    FrictionGradient, Inertia, LimitSurfaceShape, PoseOffset, PressureRadius, PusherCompliance,
    PusherFriction, PusherFrictionAsymmetry, PusherRadius, PusherStiction, RateDependentFriction,
    StreamLatency, SupportFriction, SupportStiction, TableAnisotropy, TableTilt, YawOffset, all,
    by_id,
};
pub use channels::{Channel, Channels};
pub use contact_law::ContactLaw;
pub use effect::{About, Effect, LookAlike, Moment, Sliding, Stage};
pub use error::EffectError;
pub use geometry::{Geometry, TrueOutline};
pub use object::Object;
pub use parameter::{Coordinate, Frame, Off, Parameter, Role};
pub use push_physics::PushPhysics;
pub use reading::Reading;
pub use rig::{Rig, Surface};
pub use setting::Setting;
pub use step_input::StepInput;
pub use support::{LogTensor, Support};
pub use track::Track;
