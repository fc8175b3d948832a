#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod axis;
mod box_search;
mod calibration;
mod change;
mod clusters;
mod comparison;
mod concentration;
mod condition;
mod covariate;
mod error;
mod errors;
mod finding;
mod floor_growth;
mod map_test;
mod noise_floor;
mod observations;
mod outline;
mod predictions;
mod push_ends;
mod quantile;
mod reading;
mod repeats;
mod residual_map;
mod rollout;
mod split;
mod structure;
#[cfg(test)]
mod synthetic;
mod whitening;
mod words;
mod worst;

pub use calibration::{Calibration, Covered};
pub use change::{ChannelChange, change};
pub use comparison::{Comparison, compare};
pub use concentration::Concentration;
pub use condition::Condition;
pub use covariate::Covariate;
pub use error::DiagnosisError;
pub use errors::ChannelError;
pub use finding::Finding;
pub use noise_floor::{Floor, FloorSource, NoiseFloor, noise_floor};
pub use observations::{Observations, PushName};
pub use outline::{OutlineCell, OutlineMap, outline_maps};
pub use predictions::Predictions;
pub use push_ends::{PushEnd, PushEnds, Spread, push_ends};
pub use repeats::RepeatTolerance;
pub use residual_map::{Cell, MapSettings, ResidualMap};
pub use rollout::{Rollout, roll_out};
pub use split::split;
pub use whitening::{PushCovariance, Whitening};
pub use worst::WorstPush;
