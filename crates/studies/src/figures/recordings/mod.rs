//! Chapter 4, and the sensors' noise of chapter 5: what was recorded, and the table made of it.

mod choice;
mod fold;
pub(crate) mod force_profile;
mod force_scan;
pub(crate) mod inputs_notation;
pub(crate) mod noise;
pub(crate) mod outputs;
pub(crate) mod outputs_notation;
pub(crate) mod two_pushes;
