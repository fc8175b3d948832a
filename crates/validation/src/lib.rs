#![doc = include_str!("../README.md")]

pub mod rig_calibration;
pub mod trials;
