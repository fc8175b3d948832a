#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod change;
mod clusters;
mod comparison;
mod covariate;
mod error;
mod errors;
mod noise_floor;
mod observations;
mod outline;
mod predictions;
mod quantile;
mod repeats;
mod residual_map;
mod rollout;
mod split;
mod whitening;
mod worst;

pub use change::{ChannelChange, change};
pub use comparison::{Comparison, compare};
pub use covariate::Covariate;
pub use error::DiagnosisError;
pub use errors::ChannelError;
pub use noise_floor::{Floor, FloorSource, NoiseFloor, noise_floor};
pub use observations::{Observations, PushName};
pub use outline::{OutlineCell, OutlineMap, outline_maps};
pub use predictions::Predictions;
pub use repeats::RepeatTolerance;
pub use residual_map::{Cell, MapSettings, ResidualMap};
pub use rollout::{Rollout, roll_out};
pub use split::split;
pub use whitening::{PushCovariance, Whitening};
pub use worst::WorstPush;
