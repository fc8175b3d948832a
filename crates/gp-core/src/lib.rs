#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod bayesian_linear;
mod bfgs;
mod checks;
mod cholesky;
mod error;
mod gp;
mod joint_gaussian;
mod kernel;
mod learn;
mod leave_one_out;
mod likelihood;
mod model;
mod posterior;
pub mod scores;
mod search_space;

pub use bayesian_linear::BayesianLinear;
pub use bfgs::StopReason;
pub use error::GpError;
pub use gp::{Gp, Mean};
pub use joint_gaussian::JointGaussian;
pub use kernel::{
    Kernel, KernelSpec, Matern32, Matern32Profile, Matern52, Matern52Profile, Parameter, Periodic,
    Product, Profile, Radial, Role, SquaredExponential, SquaredExponentialProfile, cross, gram,
};
pub use learn::{HyperPrior, LearnOptions, LearnReport, StartReport};
pub use leave_one_out::LeaveOneOut;
pub use model::GpModel;
pub use posterior::Posterior;
