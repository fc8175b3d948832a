//! From its plain data to a kernel.

use super::{
    ActiveInputs, Constant, Kernel, KernelSpec, Linear, Matern32, Matern52, Periodic, Product,
    SquaredExponential, Sum,
};
use crate::GpError;

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
