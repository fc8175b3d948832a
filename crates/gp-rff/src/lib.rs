#![doc = include_str!("../README.md")]

mod builder;
mod draw;
mod evaluator;
mod evidence;
mod feature_rows;
mod features;
mod layout;
mod learn;
mod likelihood;
mod model;
mod options;
mod report;
mod rff_gp;
mod spectrum;
mod statistics;
mod totals;
mod waves;

pub use builder::RffGpBuilder;
pub use evaluator::Evaluator;
pub use features::{FeatureOptions, Form, RandomFeatures};
pub use model::RffGpModel;
pub use options::{Hyperparameters, RffOptions};
pub use report::RffReport;
pub use rff_gp::RffGp;
pub use spectrum::{Sampling, Spectrum};
pub use statistics::SufficientStatistics;
pub use waves::{AveragedWaves, Waves};
