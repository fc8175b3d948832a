//! Samples with noise go in, smooth curves and robust sizes of the noise come out.

pub(crate) mod banded;
pub(crate) mod noise;
pub(crate) mod sample;
pub(crate) mod smoothing;
pub(crate) mod spline;
