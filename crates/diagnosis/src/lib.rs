#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod candidates;
mod change;
mod clusters;
mod comparison;
mod covariate;
mod coverage;
mod error;
mod error_shapes;
mod errors;
mod noise_floor;
mod noise_model;
mod observations;
mod predictions;
mod quantile;
mod repeats;
mod residual_map;
mod score;
mod screen;
mod secants;
mod sign_flips;
mod split;
mod steady_ingest;
mod tolerances;
mod untestable;
mod variances;
mod whitened;
mod whitening;
mod worst;

pub use change::{ChannelChange, change};
pub use comparison::{Comparison, compare};
pub use covariate::Covariate;
pub use coverage::Coverage;
pub use error::DiagnosisError;
pub use errors::ChannelError;
pub use noise_floor::{Floor, FloorSource, NoiseFloor, noise_floor};
pub use noise_model::{ErrorSource, NoiseModel};
pub use observations::{Observations, PushName};
pub use predictions::Predictions;
pub use repeats::RepeatTolerance;
pub use residual_map::{Cell, MapSettings, ResidualMap};
pub use screen::{
    Calibration, LookAlikes, Nuisance, Screen, ScreenSettings, ScreenedCoordinate, ScreenedEffect,
    screen,
};
pub use split::split;
pub use steady_ingest::steady_ingest;
pub use tolerances::Tolerances;
pub use untestable::{NotTestable, Reason};
pub use whitening::{PushCovariance, Whitening};
pub use worst::WorstPush;
