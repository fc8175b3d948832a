#![doc = include_str!("../README.md")]

// From the ground up: what comes first knows nothing of what comes after it.
mod elementary;
mod error;

mod object;

mod step;

mod effect;

mod catalogue;

mod predict;

#[cfg(doctest)]
mod pages;

pub use {mechanics, nalgebra, planar};

pub use catalogue::*;
pub use effect::contact_law::ContactLaw;
pub use effect::geometry::{Geometry, TrueOutline};
pub use effect::measurement::MeasurementModel;
pub use effect::nuisance::{Nuisance, Tolerance};
pub use effect::parameter::{Coordinate, Frame, Off, Parameter, Role};
pub use effect::readable_unit::readable_unit;
pub use effect::setting::Setting;
pub use effect::spread::{Spread, deviations};
pub use effect::support::{LogTensor, Support};
pub use effect::{Confounder, Effect, EffectInfo, IntoEffect, Origin, Snapshot, Stage};
pub use error::EffectError;
pub use object::Object;
pub use object::sliding::{LocalFriction, Sliding, SlidingPoints};
pub use object::spots::Spot;
pub use object::support_summary::SupportSummary;
pub use predict::Predicted;
pub use predict::parts::PredictedParts;
pub use predict::push_physics::PushPhysics;
pub use step::channels::{Channel, Channels};
pub use step::input::StepInput;
pub use step::rig::{Rig, Surface};
pub use step::run_up::{PushMoment, RunUp};
pub use step::track::Track;
