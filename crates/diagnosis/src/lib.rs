#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod axis;
mod box_search;
mod change;
mod clusters;
mod comparison;
mod covariate;
mod error;
mod errors;
mod finding;
mod map_test;
mod noise_floor;
mod observations;
mod predictions;
mod quantile;
mod reading;
mod repeats;
mod residual_map;
mod structure;
mod words;
mod worst;

pub use change::{ChannelChange, change};
pub use comparison::{Comparison, compare};
pub use covariate::Covariate;
pub use error::DiagnosisError;
pub use errors::ChannelError;
pub use finding::{Condition, Finding};
pub use noise_floor::{Floor, FloorSource, NoiseFloor, noise_floor};
pub use observations::{Observations, PushName};
pub use predictions::Predictions;
pub use repeats::RepeatTolerance;
pub use residual_map::{Cell, MapSettings, ResidualMap};
pub use worst::WorstPush;
