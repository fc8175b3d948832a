//! Chapter 3: Gaussian processes before and after data, and what they take for noise.

pub(crate) mod changing_noise;
pub(crate) mod known_noise;
pub(crate) mod posterior;
pub(crate) mod prior;
