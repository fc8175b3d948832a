//! The list of all kernels, as plain data that can be saved.

use serde::{Deserialize, Serialize};

use super::{
    ActiveInputs, Constant, Kernel, Linear, Matern32, Matern52, Periodic, Product,
    SquaredExponential, Sum,
};
use crate::GpError;

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

impl KernelSpec {
    /// The kernel that this describes.
    ///
    /// # Errors
    /// What the kernel's constructor refuses: `Empty`, `ShapeMismatch`, `NotPositive` or `OutOfRange`.
    pub fn build(&self) -> Result<Box<dyn Kernel>, GpError> {
        Ok(match self {
            Self::SquaredExponential { lengthscales, signal_variance } => {
                Box::new(SquaredExponential::new(lengthscales, *signal_variance)?)
            }
            Self::Matern32 { lengthscales, signal_variance } => {
                Box::new(Matern32::new(lengthscales, *signal_variance)?)
            }
            Self::Matern52 { lengthscales, signal_variance } => {
                Box::new(Matern52::new(lengthscales, *signal_variance)?)
            }
            Self::Periodic { periods, widths } => Box::new(Periodic::new(periods, widths)?),
            Self::Product { first, second } => {
                Box::new(Product::new(first.build()?, second.build()?)?)
            }
            Self::Sum { first, second } => Box::new(Sum::new(first.build()?, second.build()?)?),
            Self::Linear { slope_variances } => Box::new(Linear::new(slope_variances)?),
            Self::Constant { n_inputs, variance } => Box::new(Constant::new(*n_inputs, *variance)?),
            Self::ActiveInputs { kernel, columns, n_inputs } => {
                Box::new(ActiveInputs::new(kernel.build()?, columns, *n_inputs)?)
            }
        })
    }
}
