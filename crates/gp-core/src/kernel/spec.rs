//! The list of all kernels, as plain data that can be saved.

use serde::{Deserialize, Serialize};

use super::PerInput;

/// A kernel with its parameter values, as it is written to a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
#[non_exhaustive]
pub enum KernelSpec {
    /// `SquaredExponential`.
    SquaredExponential {
        /// One, or one an input, in the input's unit.
        lengthscales: PerInput,
        /// In the squared unit of the output.
        signal_variance: f64,
    },
    /// `Matern12`.
    Matern12 {
        /// One, or one an input, in the input's unit.
        lengthscales: PerInput,
        /// In the squared unit of the output.
        signal_variance: f64,
    },
    /// `Matern32`.
    Matern32 {
        /// One, or one an input, in the input's unit.
        lengthscales: PerInput,
        /// In the squared unit of the output.
        signal_variance: f64,
    },
    /// `Matern52`.
    Matern52 {
        /// One, or one an input, in the input's unit.
        lengthscales: PerInput,
        /// In the squared unit of the output.
        signal_variance: f64,
    },
    /// `RationalQuadratic`.
    RationalQuadratic {
        /// One, or one an input, in the input's unit.
        lengthscales: PerInput,
        /// Without unit.
        alpha: f64,
        /// In the squared unit of the output.
        signal_variance: f64,
    },
    /// `Polynomial`.
    Polynomial {
        /// The highest power.
        degree: u32,
        /// One, or one an input, in the input's unit.
        lengthscales: PerInput,
        /// In the squared unit of the output.
        signal_variance: f64,
    },
    /// `Periodic`.
    Periodic {
        /// One, or one an input, in the input's unit.
        periods: PerInput,
        /// One, or one an input, without unit.
        #[serde(alias = "widths")]
        lengthscales: PerInput,
    },
    /// `Cosine`.
    Cosine {
        /// One, or one an input, in the input's unit.
        periods: PerInput,
        /// In the squared unit of the output.
        signal_variance: f64,
    },
    /// `Product`.
    Product {
        /// The first factor.
        first: Box<KernelSpec>,
        /// The second factor.
        second: Box<KernelSpec>,
    },
    /// `Sum`.
    Sum {
        /// The first term.
        first: Box<KernelSpec>,
        /// The second term.
        second: Box<KernelSpec>,
    },
    /// `Linear`.
    Linear {
        /// One, or one an input, in squared units of output over input.
        slope_variances: PerInput,
    },
    /// `Constant`.
    Constant {
        /// In the squared unit of the output.
        variance: f64,
    },
    /// `White`.
    White {
        /// In the squared unit of the output.
        variance: f64,
    },
    /// `Coregionalization`.
    Coregionalization {
        /// One an output, in the squared unit of the output.
        variances: Vec<f64>,
        /// One a pair of outputs, without unit; none if they share nothing.
        odds: Vec<f64>,
        /// How many functions they share; none where odds are of pairs of outputs.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        rank: Option<usize>,
    },
    /// `ActiveInputs`.
    ActiveInputs {
        /// The kernel over the chosen inputs.
        kernel: Box<KernelSpec>,
        /// The chosen inputs, from zero.
        columns: Vec<usize>,
    },
}
