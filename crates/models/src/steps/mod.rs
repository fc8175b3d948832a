//! A step table goes in, steps and whole pushes come out, as models see them and with what was
//! observed.

pub(crate) mod channel_steps;
pub(crate) mod contact_gap;
pub(crate) mod contact_place;
pub(crate) mod excluded;
pub(crate) mod outline;
pub(crate) mod prediction;
pub(crate) mod push_path;
pub(crate) mod pushed;
pub(crate) mod recorded_push;
pub(crate) mod seen_steps;
pub(crate) mod split;
pub(crate) mod step;
pub(crate) mod step_features;
pub(crate) mod table_steps;
