#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod balance;
mod design;
mod energy;
mod error;
mod generate;
mod hidden;
mod integrate;
mod numerics;
mod outline;
mod pads;
mod planned_push;
mod plant;
mod push_list;
mod pushed_object;
mod random;
mod resistance;
mod rig;
mod scatter;
mod sealed_truth;
mod sensors;
mod state;
mod surroundings;
mod tip_contact;
mod tip_path;
mod trajectory;
mod truth;
mod variation;

pub use design::{Design, Layout};
pub use energy::Energy;
pub use error::PlantError;
pub use generate::{
    GenerateReport, GenerateSettings, SetOutput, SimulatedPush, generate, generate_each, simulate,
};
pub use hidden::{EffectKind, Hidden, HiddenEffect, Parameter, Quantity, effect_kinds};
pub use numerics::Numerics;
pub use planned_push::PlannedPush;
pub use plant::Plant;
pub use push_list::read_push_list;
pub use pushed_object::{Nominal, PushedObject, read_rig};
pub use scatter::Scatter;
pub use sensors::{Sensor, Sensors};
pub use tip_path::TipPath;
pub use trajectory::Trajectory;
pub use truth::{
    Body, Cable, Clocks, ForceSensor, FrictionMap, Grain, Groove, HeightMap, Hysteresis, Magnet,
    Markers, Pressure, RateLaw, Spot, SupportFriction, Tip, TipFriction, Truth, Wear, Wobble,
};
pub use variation::Variation;
