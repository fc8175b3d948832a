#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod axis;
mod box_search;
mod calibration;
mod candidates;
mod change;
mod clusters;
mod comparison;
mod concentration;
mod condition;
mod covariate;
mod coverage;
mod diagnose;
mod error;
mod error_shapes;
mod errors;
mod finding;
mod fit;
mod floor_growth;
mod map_test;
mod motion_steps;
mod noise_floor;
mod noise_model;
mod observations;
mod outline;
mod predictions;
mod push_ends;
mod quantile;
mod reading;
mod repeats;
mod residual_map;
mod rollout;
mod score;
mod screen;
mod secants;
mod second_set;
mod sign_flips;
mod split;
mod steady_ingest;
mod structure;
mod suggest;
mod suspicions;
#[cfg(test)]
mod synthetic;
mod tangent;
mod thinning;
mod tolerances;
mod untestable;
mod variances;
mod whitened;
mod whitening;
mod words;
mod worst;

pub use calibration::{Covered, IntervalCalibration};
pub use change::{ChannelChange, change};
pub use comparison::{Comparison, compare};
pub use concentration::Concentration;
pub use condition::Condition;
pub use covariate::Covariate;
pub use coverage::Coverage;
pub use diagnose::{
    Clusters, DataUsed, DiagnoseSettings, Diagnosed, Diagnosis, EffectFinding, ErrorFall, Gain,
    Leftover, MadeBy, MadeFrom, MotionError, NoiseOrigin, ParameterFinding, Status, Verdict,
    diagnose,
};
pub use error::DiagnosisError;
pub use errors::ChannelError;
pub use finding::Finding;
pub use fit::{
    EffectFit, Fit, FitSettings, Interval, NuisanceFit, ParameterFit, Resemblance, Undetermined,
    fit, fit_with_noise,
};
pub use noise_floor::{Floor, FloorSource, NoiseFloor, noise_floor};
pub use noise_model::{ErrorSource, NoiseModel};
pub use observations::{Observations, PushName};
pub use outline::{OutlineCell, OutlineMap, outline_maps};
pub use predictions::Predictions;
pub use push_ends::{PushEnd, PushEnds, Spread, push_ends};
pub use repeats::RepeatTolerance;
pub use residual_map::{Cell, MapSettings, ResidualMap};
pub use rollout::{Rollout, roll_out};
pub use screen::{
    Calibration, LookAlikes, Nuisance, Screen, ScreenSettings, ScreenedCoordinate, ScreenedEffect,
    screen,
};
pub use split::split;
pub use steady_ingest::steady_ingest;
pub use suggest::{
    Aim, Precision, Separation, SuggestSettings, SuggestedPush, Suggestion, suggest,
};
pub use suspicions::{CHECKS, Check, SUSPECTED_RECORDINGS, Suspicion, step_suspicions, suspicions};
pub use tolerances::Tolerances;
pub use untestable::{NotTestable, Reason};
pub use whitening::{PushCovariance, Whitening};
pub use worst::WorstPush;
