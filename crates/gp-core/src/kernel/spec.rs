//! The list of all kernels, as plain data that can be saved.

use serde::{Deserialize, Serialize};

use super::{Kernel, Matern32, Matern52, Periodic, Product, SquaredExponential};
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
}

impl KernelSpec {
    /// The kernel that this describes.
    ///
    /// # Errors
    /// What the kernel's constructor refuses: `Empty`, `ShapeMismatch` or `NotPositive`.
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
        })
    }
}
