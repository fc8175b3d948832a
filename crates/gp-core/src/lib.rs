#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod bayesian_linear;
pub mod bfgs;
pub mod checks;
pub mod cholesky;
mod error;
mod gp;
mod joint_gaussian;
pub mod kernel;
mod learn;
mod leave_one_out;
mod likelihood;
mod model;
mod posterior;
pub mod scores;
mod search_space;
pub mod vector;

pub use bayesian_linear::BayesianLinear;
pub use bfgs::StopReason;
pub use cholesky::Cholesky;
pub use error::GpError;
pub use gp::{Gp, Mean};
pub use joint_gaussian::JointGaussian;
pub use kernel::{
    Kernel, KernelSpec, Matern32, Matern32Profile, Matern52, Matern52Profile, Parameter, Periodic,
    Product, Profile, Radial, Role, SquaredExponential, SquaredExponentialProfile, cross, gram,
};
pub use learn::{HyperPrior, LearnOptions, LearnReport, StartReport, check_learnable};
pub use leave_one_out::LeaveOneOut;
pub use model::GpModel;
pub use posterior::Posterior;
pub use search_space::SearchSpace;
