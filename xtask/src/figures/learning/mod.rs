//! Chapter 3: Gaussian processes before and after data.

pub(crate) mod posterior;
pub(crate) mod prior;
