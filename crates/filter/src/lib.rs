#![doc = include_str!("../README.md")]

mod density_grid;
mod error;
mod gaussian;
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
pub use measurement_model::MeasurementModel;
pub use mixture::Mixture;
pub use motion_model::{DrawnMotion, MotionModel};
pub use particle_filter::{ParticleFilter, Update};
pub use planar_summary::{PlanarState, PlanarSummary};
pub use resampler::{Multinomial, Resampler, Residual, Stratified, Systematic, all_resamplers};
pub use rule::{GaussHermite, Rule, Unscented};
pub use settings::Settings;
pub use weights::Weights;
