#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod energy;
mod error;
mod integrate;
mod numerics;
mod outline;
mod pads;
mod plant;
mod resistance;
mod rig;
mod state;
mod tip_contact;
mod tip_path;
mod trajectory;
mod truth;
mod variation;

pub use energy::Energy;
pub use error::PlantError;
pub use numerics::Numerics;
pub use plant::Plant;
pub use tip_path::TipPath;
pub use trajectory::Trajectory;
pub use variation::Variation;

pub use truth::{
    Body, Cable, Clocks, ForceSensor, FrictionMap, Grain, Groove, HeightMap, Hysteresis, Magnet,
    Markers, Pressure, RateLaw, Spot, SupportFriction, Tip, TipFriction, Truth, Wear, Wobble,
};
