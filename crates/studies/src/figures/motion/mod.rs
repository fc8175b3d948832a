//! Chapter 6: the motion over time, with its uncertainty.

pub(crate) mod beside;
pub(crate) mod calibration;
pub(crate) mod clouds;
mod divergence;
mod ends;
pub(crate) mod errors;
pub(crate) mod estimation;
mod neighbors;
pub(crate) mod new_paths;
mod pushes;
pub(crate) mod repeats;
mod scene;
mod trained;
pub(crate) mod vertex;
mod view;
pub(crate) mod without_particles;

pub(crate) use self::scene::Scene;
pub(crate) use self::trained::Setting;
