//! From its plain data to a kernel.

use super::{
    ActiveInputs, Constant, Coregionalization, Cosine, Kernel, KernelSpec, Linear, Matern12,
    Matern32, Matern52, Periodic, Polynomial, Product, RationalQuadratic, SquaredExponential, Sum,
    White,
};

impl KernelSpec {
    /// The kernel that this describes; what it is given to checks its values, as of any kernel.
    pub fn build(&self) -> Box<dyn Kernel> {
        match self.clone() {
            Self::SquaredExponential { lengthscales, signal_variance } => {
                Box::new(SquaredExponential::of(lengthscales, signal_variance))
            }
            Self::Matern12 { lengthscales, signal_variance } => {
                Box::new(Matern12::of(lengthscales, signal_variance))
            }
            Self::Matern32 { lengthscales, signal_variance } => {
                Box::new(Matern32::of(lengthscales, signal_variance))
            }
            Self::Matern52 { lengthscales, signal_variance } => {
                Box::new(Matern52::of(lengthscales, signal_variance))
            }
            Self::RationalQuadratic { lengthscales, alpha, signal_variance } => {
                Box::new(RationalQuadratic::new(lengthscales, alpha, signal_variance))
            }
            Self::Polynomial { degree, lengthscales, signal_variance } => {
                Box::new(Polynomial::new(degree, lengthscales, signal_variance))
            }
            Self::Periodic { periods, lengthscales } => {
                Box::new(Periodic::of(periods, lengthscales))
            }
            Self::Cosine { periods, signal_variance } => {
                Box::new(Cosine::new(periods, signal_variance))
            }
            Self::Product { first, second } => {
                Box::new(Product::new(first.build(), second.build()))
            }
            Self::Sum { first, second } => Box::new(Sum::new(first.build(), second.build())),
            Self::Linear { slope_variances } => Box::new(Linear::from(slope_variances)),
            Self::Constant { variance } => Box::new(Constant::new(variance)),
            Self::White { variance } => Box::new(White::new(variance)),
            Self::Coregionalization { variances, odds, rank } => {
                Box::new(Coregionalization::of(&variances, &odds, rank))
            }
            Self::ActiveInputs { kernel, columns } => {
                Box::new(ActiveInputs::new(kernel.build(), &columns))
            }
        }
    }
}
