#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod analytical;
mod analytical_fit;
mod channel_model;
mod channel_steps;
mod description;
mod error;
mod estimate;
mod gp_push_model;
mod hybrid;
mod kinds;
mod least_squares;
mod model_effect;
mod model_file;
mod push_model;
mod set_aside;
mod split;
mod step;
mod step_gps;
mod surface_kind;
mod table_steps;

pub use analytical::{Analytical, CharacteristicLength};
pub use analytical_fit::AnalyticalFit;
pub use channel_model::ChannelModel;
pub use channel_steps::{ChannelObservation, ChannelSteps};
pub use description::{Base, Description, Weights};
pub use error::ModelError;
pub use estimate::Estimate;
pub use gp_push_model::GpPushModel;
pub use hybrid::Hybrid;
pub use kinds::{ModelKind, Train, learn_options, model_kinds};
pub use model_effect::ModelEffect;
pub use model_file::ModelFile;
pub use push_model::{Noise, OUTPUTS, PushModel, StepPrediction};
pub use set_aside::{SetAside, SetAsideReason};
pub use split::{Cluster, Split};
pub use step::{StepInput, StepObservation};
pub use surface_kind::SurfaceKind;
pub use table_steps::{StepSelection, TableSteps};
