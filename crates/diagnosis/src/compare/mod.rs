//! Predictions, observed steps and the noise floor go in, where and by how much the model fails
//! comes out.

pub(crate) mod axis;
pub(crate) mod calibration;
pub(crate) mod cells;
pub(crate) mod change;
pub(crate) mod comparison;
pub(crate) mod concentration;
pub(crate) mod condition;
pub(crate) mod error_sums;
pub(crate) mod errors;
pub(crate) mod finding;
pub(crate) mod outline;
pub(crate) mod reading;
pub(crate) mod residual_columns;
pub(crate) mod residual_map;
pub(crate) mod structure;
pub(crate) mod sums;
pub(crate) mod words;
pub(crate) mod worst;
