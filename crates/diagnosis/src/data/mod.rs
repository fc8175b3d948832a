//! A table of steps goes in, the observed steps come out, with the clusters that share errors and
//! the parts that are held out.

pub(crate) mod clusters;
pub(crate) mod covariate;
pub(crate) mod coverage;
pub(crate) mod footprints;
pub(crate) mod kept_steps;
pub(crate) mod local_residuals;
pub(crate) mod motion_steps;
pub(crate) mod nominal_motion;
pub(crate) mod observations;
pub(crate) mod observed_clusters;
pub(crate) mod own_numbers;
pub(crate) mod pose_jumps;
pub(crate) mod repeats;
pub(crate) mod runs;
pub(crate) mod runs_of_rows;
pub(crate) mod second_set;
pub(crate) mod split;
pub(crate) mod steady_ingest;
pub(crate) mod step_checks;
pub(crate) mod step_suspicions;
pub(crate) mod thinning;
pub(crate) mod tolerances;
