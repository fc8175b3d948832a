#![doc = include_str!("../README.md")]

mod density_grid;
mod error;
mod gaussian;
mod gaussian_measurement;
mod gaussian_motion;
mod gaussian_update;
mod linearized;
mod measurement_model;
mod mixture;
mod motion_model;
mod particle_filter;
mod planar_summary;
mod random_stream;
mod resampler;
mod rule;
mod settings;
mod slab;
mod weights;

pub use density_grid::{DensityGrid, Mode};
pub use error::FilterError;
pub use gaussian::Gaussian;
pub use gaussian_measurement::{DifferentiableMeasurement, GaussianMeasurement, LinearMeasurement};
pub use gaussian_motion::{LinearMotion, Prediction, rauch_tung_striebel};
pub use gaussian_update::{GaussianUpdate, MixtureUpdate};
pub use measurement_model::MeasurementModel;
pub use mixture::Mixture;
pub use motion_model::{DrawnMotion, MotionDensity, MotionModel};
pub use particle_filter::{KldSampling, ParticleFilter, ParticleHistory, RaoBlackwellized, Update};
pub use planar_summary::{PlanarState, PlanarSummary};
pub use resampler::{Multinomial, Resampler, Residual, Stratified, Systematic, all_resamplers};
pub use rule::{GaussHermite, Rule, Simplex, Unscented};
pub use settings::Settings;
pub use weights::Weights;
