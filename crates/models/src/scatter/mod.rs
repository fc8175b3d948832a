//! Recorded pushes and a model that has not seen them go in, how the errors of steps go together
//! comes out.

pub(crate) mod calibration;
pub(crate) mod end_check;
pub(crate) mod error_products;
pub(crate) mod measured_correlation;
pub(crate) mod push_errors;
pub(crate) mod push_scatter;

pub(crate) mod given_draw;
pub(crate) mod watched;
mod whitened;
