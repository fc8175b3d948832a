#![doc = include_str!("../README.md")]

mod approximation;
mod block;
mod choose_size;
mod deviation;
mod expansion;
mod learn;
mod model;
mod objective;
mod part;
mod placement;
mod reduction;
mod sparse_gp;

pub use approximation::{Approximation, SparseSettings};
pub use choose_size::SizeScore;
pub use deviation::Deviation;
pub use learn::{SparseOptions, SparseReport, SparseStart};
pub use model::SparseGpModel;
pub use placement::{Placement, PseudoInputs};
pub use sparse_gp::{Evaluator, SparseGp};
