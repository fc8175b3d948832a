//! The linear kernel.

use super::{Kernel, KernelSpec, Parameter, Role};
use crate::GpError;
use crate::checks::{check_count, check_positive};

/// k(a, b) = Σ_d v_d a_d b_d: straight lines through the origin with slopes of variance v_d.
///
/// Add a `Constant` for lines with an offset. It is not stationary: the variance grows as the square
/// of the distance from the origin.
/// Parameters in order: the slope variances v_d, in squared units of output over input d.
#[derive(Clone, Debug, PartialEq)]
pub struct Linear {
    slope_variances: Vec<f64>,
}

impl Linear {
    /// A kernel with one slope variance an input.
    ///
    /// # Errors
    /// `Empty` without variances; `NotPositive` for one that is not positive and finite.
    pub fn new(slope_variances: &[f64]) -> Result<Self, GpError> {
        if slope_variances.is_empty() {
            return Err(GpError::Empty { what: "slope variances" });
        }
        for (d, &variance) in slope_variances.iter().enumerate() {
            check_positive(&format!("slope variance {d}"), variance)?;
        }
        Ok(Self { slope_variances: slope_variances.to_vec() })
    }

    /// The slope variances v_d.
    pub fn slope_variances(&self) -> &[f64] {
        &self.slope_variances
    }
}

impl Kernel for Linear {
    fn n_inputs(&self) -> usize {
        self.slope_variances.len()
    }

    fn value(&self, a: &[f64], b: &[f64]) -> f64 {
        self.slope_variances.iter().zip(a).zip(b).map(|((v, a), b)| v * a * b).sum()
    }

    fn parameters(&self) -> Vec<Parameter> {
        let parameter = |(input, &value): (usize, &f64)| Parameter {
            name: format!("slope variance {input}"),
            value,
            role: Role::SlopeVariance { input },
        };
        self.slope_variances.iter().enumerate().map(parameter).collect()
    }

    fn with_parameters(&self, values: &[f64]) -> Result<Box<dyn Kernel>, GpError> {
        check_count("kernel parameters", self.slope_variances.len(), values.len())?;
        Ok(Box::new(Self::new(values)?))
    }

    fn parameter_gradient(&self, a: &[f64], b: &[f64], gradient: &mut [f64]) {
        for (d, slope) in gradient.iter_mut().enumerate() {
            *slope = self.slope_variances[d] * a[d] * b[d];
        }
    }

    fn input_gradient(&self, _a: &[f64], b: &[f64], gradient: &mut [f64]) {
        for (d, slope) in gradient.iter_mut().enumerate() {
            *slope = self.slope_variances[d] * b[d];
        }
    }

    fn spec(&self) -> Option<KernelSpec> {
        Some(KernelSpec::Linear { slope_variances: self.slope_variances.clone() })
    }
}
