//! A path goes in, bytes come out, within limits and whatever a library does with them.

pub(crate) mod caught;
pub(crate) mod limits;
pub(crate) mod map;
pub(crate) mod unpack;
