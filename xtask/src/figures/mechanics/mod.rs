//! Chapter 2: friction, limit surfaces and the analytical push.

pub(crate) mod analytical;
pub(crate) mod ellipsoid;
pub(crate) mod few_points;
pub(crate) mod limit_curve;
pub(crate) mod normals;
pub(crate) mod one_point;
mod rays;
