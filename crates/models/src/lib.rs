#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod analytical;
mod analytical_fit;
mod beside_physics;
mod channel_model;
mod channel_steps;
mod closed_form;
mod contact_place;
mod description;
mod error;
mod estimate;
mod gp_push_model;
mod held_scatter;
mod hybrid;
mod kinds;
mod least_squares;
mod measurements;
mod model_effect;
mod model_file;
mod outline;
mod physics;
mod physics_fit;
mod physics_model;
mod process;
mod push_model;
mod push_path;
mod recorded_push;
mod roll_out;
mod seen_steps;
mod set_aside;
mod slip_mixture;
mod split;
mod step;
mod step_correlation;
mod step_features;
mod step_processes;
mod step_table;
mod surface_kind;
mod table_steps;
mod training;

pub use analytical::{Analytical, CharacteristicLength};
pub use analytical_fit::AnalyticalFit;
pub use beside_physics::{BesidePhysics, Unexplained};
pub use channel_model::ChannelModel;
pub use channel_steps::{ChannelObservation, ChannelSteps};
pub use description::{Base, Description, Weights};
pub use error::ModelError;
pub use estimate::Estimate;
pub use gp_push_model::GpPushModel;
pub use hybrid::{Hybrid, HybridReport};
pub use kinds::{ModelKind, Train, model_kinds};
pub use measurements::{ForceSeen, PoseSeen};
pub use model_effect::ModelEffect;
pub use model_file::ModelFile;
pub use outline::Outline;
pub use physics::Setup;
pub use process::{ProcessKind, ProcessModel, ProcessReport};
pub use push_model::{Noise, OUTPUTS, Parts, PushModel, StepPrediction};
pub use push_path::{PathStep, PushPath};
pub use recorded_push::RecordedPush;
pub use roll_out::{
    Matching, Moment, PushEvents, PushMotion, PushParticle, Pushed, RollOut, RollOutSettings,
    StepErrors,
};
pub use seen_steps::SeenSteps;
pub use set_aside::{SetAside, SetAsideReason};
pub use slip_mixture::{Slip, SlipMixture, SlipPrediction};
pub use split::{Cluster, Split};
pub use step::{StepInput, StepObservation};
pub use step_correlation::StepCorrelation;
pub use step_features::StepFeatures;
pub use step_table::TableReport;
pub use surface_kind::SurfaceKind;
pub use table_steps::{StepSelection, TableSteps};
pub use training::{Training, learn_options};
