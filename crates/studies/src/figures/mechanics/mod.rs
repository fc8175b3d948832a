//! Chapter 2: friction, limit surfaces and the analytical push.

pub(crate) mod analytical;
pub(crate) mod ellipsoid;
pub(crate) mod few_points;
pub(crate) mod friction_cone;
pub(crate) mod limit_curve;
pub(crate) mod motion_cone;
pub(crate) mod normals;
pub(crate) mod one_point;
pub(crate) mod pressure;
mod rays;
pub(crate) mod rigid_body;
pub(crate) mod stick_slide;
mod top_view;
