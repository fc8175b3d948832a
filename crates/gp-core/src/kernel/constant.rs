//! The constant kernel.

use super::{Kernel, KernelSpec, Parameter, Role};
use crate::GpError;
use crate::checks::{check_count, check_positive};

/// k(a, b) = s²: functions that are the same everywhere; as a factor, the variance of another kernel.
#[derive(Clone, Debug, PartialEq)]
pub struct Constant {
    n_inputs: usize,
    variance: f64,
}

impl Constant {
    /// A kernel of `n_inputs` inputs, none of which matters.
    ///
    /// # Errors
    /// `Empty` without inputs; `NotPositive` for a variance that is not positive and finite.
    pub fn new(n_inputs: usize, variance: f64) -> Result<Self, GpError> {
        if n_inputs == 0 {
            return Err(GpError::Empty { what: "inputs of the constant kernel" });
        }
        check_positive("variance", variance)?;
        Ok(Self { n_inputs, variance })
    }

    /// The variance s², in the squared unit of the output.
    pub fn variance(&self) -> f64 {
        self.variance
    }
}

impl Kernel for Constant {
    fn n_inputs(&self) -> usize {
        self.n_inputs
    }

    fn value(&self, _a: &[f64], _b: &[f64]) -> f64 {
        self.variance
    }

    fn parameters(&self) -> Vec<Parameter> {
        vec![Parameter { name: "variance".to_owned(), value: self.variance, role: Role::Variance }]
    }

    fn with_parameters(&self, values: &[f64]) -> Result<Box<dyn Kernel>, GpError> {
        check_count("kernel parameters", 1, values.len())?;
        Ok(Box::new(Self::new(self.n_inputs, values[0])?))
    }

    fn parameter_gradient(&self, _a: &[f64], _b: &[f64], gradient: &mut [f64]) {
        gradient[0] = self.variance;
    }

    fn input_gradient(&self, _a: &[f64], _b: &[f64], gradient: &mut [f64]) {
        gradient.fill(0.0);
    }

    fn spec(&self) -> Option<KernelSpec> {
        Some(KernelSpec::Constant { n_inputs: self.n_inputs, variance: self.variance })
    }
}
