#![doc = include_str!("../README.md")]

mod draw;
mod evaluator;
mod evidence;
mod features;
mod learn;
mod likelihood;
mod model;
mod rff_gp;
mod spectrum;
mod statistics;
mod waves;

pub use evaluator::Evaluator;
pub use features::{FeatureOptions, Form, RandomFeatures};
pub use learn::{Hyperparameters, RffOptions, RffReport};
pub use model::RffGpModel;
pub use rff_gp::RffGp;
pub use spectrum::{Sampling, Spectrum};
pub use statistics::SufficientStatistics;
pub use waves::{AveragedWaves, Waves};
