//! What the filters obey, from outside the crate.

#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

mod linear;
mod moments;
mod particle_variants;
mod particles;
mod planar;
mod resampling;
mod smoothers;
mod updates;
