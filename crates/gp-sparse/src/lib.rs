#![doc = include_str!("../README.md")]

mod approximation;
mod block;
mod choose_size;
mod deviation;
mod expansion;
mod grid;
mod grid_gp;
mod grid_learn;
mod grid_model;
mod grid_objective;
mod grid_options;
mod grid_sums;
mod learn;
mod model;
mod objective;
#[cfg(doctest)]
mod pages;
mod part;
mod placement;
mod reduction;
mod row_sums;
mod rows;
mod saved_rows;
mod sparse_gp;

pub use approximation::{Approximation, SparseSettings};
pub use choose_size::SizeScore;
pub use deviation::Deviation;
pub use grid_gp::GridGp;
pub use grid_learn::GridReport;
pub use grid_model::GridGpModel;
pub use grid_options::GridOptions;
pub use learn::{SparseOptions, SparseReport, SparseStart};
pub use model::SparseGpModel;
pub use placement::{Placement, PseudoInputs};
pub use saved_rows::SparseRows;
pub use sparse_gp::{Evaluator, SparseGp};
