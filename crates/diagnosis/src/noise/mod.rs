//! Predictions and repeats go in, the noise floor and the covariance of a push's residuals come
//! out.

mod blocks_of_pushes;
pub(crate) mod conditional_modes;
pub(crate) mod floor_growth;
pub(crate) mod noise_floor;
pub(crate) mod noise_model;
pub(crate) mod predicted_floor;
pub(crate) mod whitening;
pub(crate) mod widely_differing;
