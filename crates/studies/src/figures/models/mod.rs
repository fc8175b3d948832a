//! Chapter 5: models learned from the table, and how many steps they need.

pub(crate) mod gp_maps;
mod joint_outputs;
pub(crate) mod learning_curves;
pub(crate) mod pooled_speeds;
pub(crate) mod pseudo_inputs;
pub(crate) mod random_features;
mod rows;
pub(crate) mod shapes;
pub(crate) mod steps;
pub(crate) mod time_step;
