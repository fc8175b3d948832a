#![doc = include_str!("../README.md")]

mod bayesian_linear;
mod bayesian_linear_model;
pub mod bfgs;
pub mod blocks;
mod builder;
mod by_name;
pub mod checks;
pub mod cholesky;
mod constraints;
mod error;
mod expansion;
mod factor;
mod gaussian_input;
mod generalized_least_squares;
mod gp;
mod gp_gradients;
mod gp_queries;
mod gp_rows;
mod heteroscedastic;
mod hyper_prior;
mod inputs;
mod joint_gaussian;
pub mod kernel;
mod kronecker;
mod learn;
mod learn_noise;
mod learn_report;
mod learn_student_t;
mod leave_one_out;
mod likelihood;
mod limited_memory;
mod linear_statistics;
mod low_discrepancy;
mod mean;
mod model;
mod monomials;
mod noise;
mod noise_bound;
mod parts;
mod posterior;
mod prior;
pub mod quantile;
mod root;
mod saved;
pub mod scores;
mod search_space;
mod shared_likelihood;
mod student_t;
mod student_t_bound;
mod tile;
mod transform;
pub mod triangle;
pub mod vector;
mod warped;
mod with_mean;
mod workspace;

pub use bayesian_linear::BayesianLinear;
pub use bayesian_linear_model::BayesianLinearModel;
pub use bfgs::StopReason;
pub use builder::GpBuilder;
pub use cholesky::Cholesky;
pub use constraints::{Constraints, hyperparameter_names};
pub use error::GpError;
pub use expansion::{
    AveragedSquaredExponentialBasis, Averages, Basis, Expansion, SquaredExponentialBasis,
    UncertainOutputs,
};
pub use gaussian_input::GaussianInput;
pub use generalized_least_squares::GeneralizedLeastSquares;
pub use gp::Gp;
pub use heteroscedastic::{HeteroscedasticGp, HeteroscedasticGpModel};
pub use hyper_prior::HyperPrior;
pub use inputs::Inputs;
pub use joint_gaussian::JointGaussian;
pub use kernel::{
    ActiveInputs, Constant, Coregionalization, Cosine, Kernel, KernelSpec, Linear, Matern12,
    Matern12Profile, Matern32, Matern32Profile, Matern52, Matern52Profile, Parameter, PerInput,
    Periodic, Polynomial, Product, Profile, Radial, RationalQuadratic, Role, SquaredExponential,
    SquaredExponentialProfile, Sum, White, cross, gram,
};
pub use learn::{LearnOptions, check_learnable};
pub use learn_noise::HeteroscedasticReport;
pub use learn_report::{LearnReport, StartReport, write_hyperparameters};
pub use learn_student_t::StudentTReport;
pub use leave_one_out::LeaveOneOut;
pub use likelihood::Evaluator;
pub use linear_statistics::LinearStatistics;
pub use low_discrepancy::LowDiscrepancy;
pub use mean::Mean;
pub use model::GpModel;
pub use monomials::Monomials;
pub use parts::{Mergeable, Parts};
pub use posterior::Posterior;
pub use prior::{Gamma, InverseGamma, LogNormal, Prior};
pub use search_space::SearchSpace;
pub use student_t::{StudentTGp, StudentTGpModel};
pub use transform::Transform;
pub use warped::Warped;
pub use with_mean::{MeanFunction, WithMean};
pub use workspace::Workspace;
