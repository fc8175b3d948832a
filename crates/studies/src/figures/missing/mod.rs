//! Ours: which effect is missing, and the error that falls as it is added.

pub(crate) mod at_a_glance;
pub(crate) mod error_falls;
mod study;
pub(crate) mod which_effect;

pub(crate) use self::study::{Study, hidden_effects};
