#![doc = include_str!("../README.md")]

// From the ground up: what comes first knows nothing of what comes after it.
mod error;
mod random;

mod truth;

mod dynamics;

mod design;

mod hidden;

mod recording;

pub use design::layout::{Design, Layout};
pub use design::planned_push::PlannedPush;
pub use design::push_list::read_push_list;
pub use dynamics::energy::Energy;
pub use dynamics::ground::friction_over_table;
pub use dynamics::numerics::Numerics;
pub use dynamics::plant::Plant;
pub use dynamics::tip_path::TipPath;
pub use dynamics::trajectory::Trajectory;
pub use error::PlantError;
pub use hidden::{EffectKind, Hidden, HiddenEffect, Parameter, Quantity, effect_kinds};
pub use recording::generate::{GenerateReport, SetOutput, generate, generate_each};
pub use recording::profile::Profile;
pub use recording::pushed_object::{Nominal, PushedObject, read_rig};
pub use recording::scatter::Scatter;
pub use recording::sensors::{Flips, Sensor, Sensors};
pub use recording::simulate::{GenerateSettings, SimulatedPush, simulate};
pub use truth::variation::Variation;
pub use truth::{
    Body, Burr, Cable, Cameras, Clocks, Feet, ForceSensor, FrictionMap, Grain, Groove, HeightMap,
    Hysteresis, Magnet, Markers, Pressure, RateLaw, Spot, SupportFriction, Texture, Tip,
    TipFriction, Truth, Underside, Wear, Wobble,
};
