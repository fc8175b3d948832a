#![doc = include_str!("../README.md")]

// From the ground up: what comes first knows nothing of what comes after it.
mod error;

mod steps;

mod analytical;

mod process;

mod description;

mod physics;

mod learnt;

mod kinds;

mod roll_out;

mod scatter;

mod file;

pub use analytical::effective::EffectiveSurface;
pub use analytical::estimate::Estimate;
pub use analytical::fit::AnalyticalFit;
pub use analytical::surface_kind::SurfaceKind;
pub use analytical::{Analytical, CharacteristicLength};
pub use description::model_effect::ModelEffect;
pub use description::orthogonal_discrepancy::{OrthogonalDiscrepancy, Unexplained};
pub use description::{Base, Description, Weights};
pub use error::ModelError;
pub use file::ModelFile;
pub use file::made_for::{MadeFor, MadeForObject, RigDifference};
pub use kinds::hybrid::{Hybrid, HybridReport};
pub use kinds::push_model::PushModel;
pub use kinds::{ModelKind, Train, model_kinds};
pub use learnt::gp_push_model::GpPushModel;
pub use learnt::slip_mixture::{Slip, SlipMixture, SlipPrediction};
pub use learnt::step_table::TableReport;
pub use physics::Setup;
pub use physics::channel_model::{ChannelModel, MotionOverPushes, MotionsOfPushes};
pub use process::kind::ProcessKind;
pub use process::training::{Training, learn_options};
pub use process::{ProcessModel, ProcessReport};
pub use roll_out::carried::CarriedMotion;
pub use roll_out::measurements::{ForceSeen, PoseSeen};
pub use roll_out::push_vector::PushVector;
pub use roll_out::step_correlation::{EndCheck, StepCorrelation};
pub use roll_out::tracker::{PushTracker, Wander};
pub use roll_out::{
    Matching, Moment, PushEvents, PushMotion, PushParticle, RollOut, RollOutSettings, StepErrors,
};
pub use scatter::calibration::{Calibration, CalibrationPhase};
pub use scatter::watched::Watched;
pub use steps::channel_steps::{ChannelObservation, ChannelSteps, rigid_object};
pub use steps::contact_gap::ContactGap;
pub use steps::excluded::{Excluded, ExclusionReason};
pub use steps::outline::Outline;
pub use steps::prediction::{Noise, OUTPUTS, Parts, StepPrediction};
pub use steps::push_path::{PathStep, PushPath};
pub use steps::pushed::Pushed;
pub use steps::recorded_push::RecordedPush;
pub use steps::seen_steps::SeenSteps;
pub use steps::split::{Cluster, Split};
pub use steps::step::{StepInput, StepObservation};
pub use steps::step_features::StepFeatures;
pub use steps::table_steps::{StepSelection, TableSteps};
