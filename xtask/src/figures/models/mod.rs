//! Chapter 5: models learned from the table, and how many steps they need.

pub(crate) mod gp_maps;
pub(crate) mod learning_curves;
pub(crate) mod pooled_speeds;
pub(crate) mod steps;
