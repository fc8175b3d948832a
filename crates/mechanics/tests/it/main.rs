//! What cones, surfaces and pushes obey, from outside the crate.

#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

mod cone_laws;
mod every_surface_laws;
mod joint_laws;
mod limit_surface_laws;
mod path_laws;
mod push_laws;
mod surfaces;
mod uniform_laws;
