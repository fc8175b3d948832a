//! A pusher's path over time goes in, the object's motion over time comes out.

pub(crate) mod edge_push;
pub(crate) mod follow;
pub(crate) mod motion;
pub(crate) mod pusher_path;
pub(crate) mod travel;
