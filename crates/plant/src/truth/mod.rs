//! What is true of the rig, part by part; one file each.

pub(crate) mod variation;

mod body;
mod cable;
mod cameras;
mod check;
mod clocks;
mod feet;
mod force_sensor;
mod friction_map;
mod grain;
mod height_map;
mod magnet;
mod markers;
mod pressure;
mod rate_law;
mod support_friction;
mod texture;
mod tip;
mod tip_friction;
mod underside;
mod wear;
mod wobble;

use serde::{Deserialize, Serialize};

pub use body::Body;
pub use cable::Cable;
pub use cameras::Cameras;
pub use clocks::Clocks;
pub use feet::Feet;
pub use force_sensor::ForceSensor;
pub use friction_map::{FrictionMap, Spot};
pub use grain::Grain;
pub use height_map::{Groove, HeightMap};
pub use magnet::Magnet;
pub use markers::Markers;
pub use pressure::Pressure;
pub use rate_law::RateLaw;
pub use support_friction::SupportFriction;
pub use texture::Texture;
pub use tip::{Hysteresis, Tip};
pub use tip_friction::TipFriction;
pub use underside::Underside;
pub use wear::{Burr, Wear};
pub use wobble::Wobble;

/// Everything that is true of a rig besides the object's nominal outline, mass and moment.
///
/// The default is a plain rig: uniform Coulomb friction of 0.25, uniform pressure, a level table, a
/// round tip of 4.75 mm with friction 0.25 on a stiff arm, sensors without errors of calibration.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Truth {
    /// Which of all tables and objects with these textures; 0 for that of the set's seed.
    pub texture_seed: u64,
    /// Friction between object and table.
    pub support_friction: SupportFriction,
    /// How the support's load is spread.
    pub pressure: Pressure,
    /// The object's bottom, which may spread the load by where it stands.
    pub underside: Underside,
    /// Direction-dependent friction that stays with the table.
    pub table_grain: Grain,
    /// Direction-dependent friction that turns with the object.
    pub body_grain: Grain,
    /// Friction over the table.
    pub friction_map: FrictionMap,
    /// Height over the table.
    pub height_map: HeightMap,
    /// A foot that shares the load with its neighbors unevenly.
    pub wobble: Wobble,
    /// Mass and its center.
    pub body: Body,
    /// The outline's corners.
    pub wear: Wear,
    /// A cable that pulls at the object.
    pub cable: Cable,
    /// A magnet under the table.
    pub magnet: Magnet,
    /// The pusher's tip and what holds it.
    pub tip: Tip,
    /// Friction between tip and object.
    pub tip_friction: TipFriction,
    /// Where the tracked frame is in the object.
    pub markers: Markers,
    /// Where motion capture has its frame.
    pub cameras: Cameras,
    /// Clocks of the streams.
    pub clocks: Clocks,
    /// Calibration of the force sensor.
    pub force_sensor: ForceSensor,
}
