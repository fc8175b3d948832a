//! The list of all kernels, as plain data that can be saved.

use serde::{Deserialize, Serialize};

/// A kernel with its parameter values, as it is written to a file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
#[non_exhaustive]
pub enum KernelSpec {
    /// `SquaredExponential`.
    SquaredExponential {
        /// One an input, in the input's unit.
        lengthscales: Vec<f64>,
        /// In the squared unit of the output.
        signal_variance: f64,
    },
    /// `Matern32`.
    Matern32 {
        /// One an input, in the input's unit.
        lengthscales: Vec<f64>,
        /// In the squared unit of the output.
        signal_variance: f64,
    },
    /// `Matern52`.
    Matern52 {
        /// One an input, in the input's unit.
        lengthscales: Vec<f64>,
        /// In the squared unit of the output.
        signal_variance: f64,
    },
    /// `Periodic`.
    Periodic {
        /// One an input, in the input's unit.
        periods: Vec<f64>,
        /// One an input, without unit.
        widths: Vec<f64>,
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
        /// One an input, in squared units of output over input.
        slope_variances: Vec<f64>,
    },
    /// `Constant`.
    Constant {
        /// The number of inputs, none of which matters.
        n_inputs: usize,
        /// In the squared unit of the output.
        variance: f64,
    },
    /// `ActiveInputs`.
    ActiveInputs {
        /// The kernel over the chosen inputs.
        kernel: Box<KernelSpec>,
        /// The chosen inputs, from zero.
        columns: Vec<usize>,
        /// The number of all inputs.
        n_inputs: usize,
    },
}
