//! The rig and the pusher's path over a step, as plain numbers: what every prediction starts from.

pub(crate) mod channels;
pub(crate) mod input;
pub(crate) mod rig;
pub(crate) mod run_up;
pub(crate) mod track;
