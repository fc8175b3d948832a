//! The white kernel.

use super::{Kernel, KernelSpec, Parameter, Role};

/// k(a, b) = s² where a and b are the same input, else 0: a part of the function that is new at each
/// input, and the same again at the same one.
///
/// Unlike noise it is part of f, and of its variance; at the inputs of the data its values are learnt
/// from them. Noise that differs between two observations at one input belongs in `noise_variance`.
/// Parameter: `white.variance`, in the squared unit of the output.
#[derive(Clone, Debug, PartialEq)]
pub struct White {
    variance: f64,
}

impl White {
    /// A kernel of any number of inputs with the variance s².
    pub fn new(variance: f64) -> Self {
        Self { variance }
    }

    /// The variance s², in the squared unit of the output.
    pub fn variance(&self) -> f64 {
        self.variance
    }
}

impl Kernel for White {
    fn value(&self, a: &[f64], b: &[f64]) -> f64 {
        if a == b { self.variance } else { 0.0 }
    }

    fn parameters(&self) -> Vec<Parameter> {
        vec![Parameter::new("white.variance", self.variance, Role::Variance)]
    }

    fn with_values(&self, values: &[f64]) -> Box<dyn Kernel> {
        Box::new(Self::new(values[0]))
    }

    fn parameter_gradient(&self, a: &[f64], b: &[f64], gradient: &mut [f64]) {
        gradient[0] = self.value(a, b);
    }

    fn input_gradient(&self, _a: &[f64], _b: &[f64], gradient: &mut [f64]) {
        gradient.fill(0.0);
    }

    fn spec(&self) -> Option<KernelSpec> {
        Some(KernelSpec::White { variance: self.variance })
    }
}
