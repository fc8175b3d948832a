#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod candidates;
mod change;
mod clusters;
mod comparison;
mod covariate;
mod coverage;
mod diagnose;
mod error;
mod error_shapes;
mod errors;
mod fit;
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
pub use diagnose::{
    DataUsed, DiagnoseSettings, Diagnosed, Diagnosis, EffectFinding, ErrorFall, Gain, Leftover, MadeBy,
    MadeFrom, MotionError, NoiseOrigin, ParameterFinding, Status, Verdict, diagnose,
};
pub use error::DiagnosisError;
pub use errors::ChannelError;
pub use fit::{
    EffectFit, Fit, FitSettings, Interval, NuisanceFit, ParameterFit, Resemblance, Undetermined,
    fit, fit_with_noise,
};
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
