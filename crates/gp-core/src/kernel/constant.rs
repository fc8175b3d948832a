//! The constant kernel.

use super::{Kernel, KernelSpec, Parameter, Role};

/// k(a, b) = s²: functions that are the same everywhere; as a factor, the variance of another kernel.
///
/// Parameter: `constant.variance`, in the squared unit of the output.
#[derive(Clone, Debug, PartialEq)]
pub struct Constant {
    variance: f64,
}

impl Constant {
    /// A kernel of any number of inputs, none of which matters, with the variance s².
    pub fn new(variance: f64) -> Self {
        Self { variance }
    }

    /// The variance s², in the squared unit of the output.
    pub fn variance(&self) -> f64 {
        self.variance
    }
}

impl Kernel for Constant {
    fn value(&self, _a: &[f64], _b: &[f64]) -> f64 {
        self.variance
    }

    fn parameters(&self) -> Vec<Parameter> {
        vec![Parameter::new("constant.variance", self.variance, Role::Variance)]
    }

    fn with_values(&self, values: &[f64]) -> Box<dyn Kernel> {
        Box::new(Self::new(values[0]))
    }

    fn parameter_gradient(&self, _a: &[f64], _b: &[f64], gradient: &mut [f64]) {
        gradient[0] = self.variance;
    }

    fn input_gradient(&self, _a: &[f64], _b: &[f64], gradient: &mut [f64]) {
        gradient.fill(0.0);
    }

    fn spec(&self) -> Option<KernelSpec> {
        Some(KernelSpec::Constant { variance: self.variance })
    }
}
