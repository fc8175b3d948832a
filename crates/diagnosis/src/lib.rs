#![doc = include_str!("../README.md")]

// From the ground up: what comes first knows nothing of what comes after it.
mod error;
mod undetermined;

mod cut_offs;

mod statistics;

mod data;

mod predict;

mod noise;

mod compare;

mod screen;

mod fit;

mod remains;

mod decide;

mod suggest;

#[cfg(test)]
mod synthetic;

pub use compare::calibration::{Covered, IntervalCalibration};
pub use compare::cells::{CovariateCells, StepResiduals, step_residuals};
pub use compare::change::{ChannelChange, change};
pub use compare::comparison::{Comparison, compare};
pub use compare::concentration::Concentration;
pub use compare::condition::Condition;
pub use compare::error_sums::{ErrorGrid, ErrorMap, ErrorSums, ErrorTable};
pub use compare::errors::ChannelError;
pub use compare::finding::Finding;
pub use compare::outline::{OutlineCell, OutlineMap, outline_maps};
pub use compare::residual_columns::residual_columns;
pub use compare::residual_map::{Cell, ResidualMap};
pub use compare::structure::MapSettings;
pub use compare::worst::WorstPush;
pub use data::covariate::Covariate;
pub use data::coverage::Coverage;
pub use data::footprints::Footprints;
pub use data::observations::{Observations, PushName};
pub use data::repeats::RepeatTolerance;
pub use data::runs::Runs;
pub use data::split::split;
pub use data::steady_ingest::steady_ingest;
pub use data::step_checks::{Doubt, DoubtfulSteps};
pub use data::step_suspicions::step_suspicions;
pub use data::tolerances::Tolerances;
pub use decide::{
    Clusters, DataUsed, DiagnosePhase, DiagnoseSettings, Diagnosed, Diagnosis, EffectFinding,
    ErrorFall, Grade, Leftover, MadeBy, MadeFrom, MotionError, NoiseOrigin, ParameterFinding,
    PushScatter, Verdict, diagnose, diagnose_with_progress,
};
pub use error::DiagnosisError;
pub use fit::{
    EffectFit, FieldRegion, Fit, FitPlace, FitSettings, FrictionFieldFit, Interval, MotionErrors,
    NormalEquations, NuisanceFit, ParameterFit, PartedEffect, PartedEstimate, PartedFit,
    Resemblance, SpreadFit, SupportPointsFit, fit, fit_per_push, fit_with_noise,
};
pub use noise::noise_floor::{Floor, FloorSource, NoiseFloor, noise_floor};
pub use noise::noise_model::{ErrorSource, NoiseModel};
pub use noise::whitening::{PushCovariance, Whitening};
pub use predict::predictions::Predictions;
pub use predict::push_ends::{PushEnd, PushEnds, Spread, push_ends};
pub use predict::rollout::{Rollout, roll_out};
pub use remains::{OriginShare, Remains};
pub use screen::screen;
pub use screen::screened::{
    Calibration, LookAlikes, Nuisance, Screen, ScreenSettings, ScreenedCoordinate, ScreenedEffect,
};
pub use screen::untestable::{NotTestable, Reason, lacking};
pub use statistics::gain::Gain;
pub use suggest::{
    Aim, Precision, Separation, SuggestSettings, SuggestedPush, Suggestion, suggest,
};
pub use undetermined::Undetermined;
