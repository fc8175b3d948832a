#![doc = include_str!("../README.md")]

mod command_line;
pub mod effects_atlas;
pub mod figures;
mod held_out;
mod learned_kinds;
pub mod real_comparison;
pub mod real_data;
mod residual_grid;
pub mod samples;
pub mod simulated_and_real;
pub mod thesis_claims;

pub use command_line::main;
