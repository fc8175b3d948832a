//! Observed steps go in, models come out that know no mechanics: processes, tables of them, and
//! mixtures.

pub(crate) mod closed_form;
pub(crate) mod gp_push_model;
pub(crate) mod slip_gate;
pub(crate) mod slip_mixture;
pub(crate) mod step_processes;
pub(crate) mod step_table;
