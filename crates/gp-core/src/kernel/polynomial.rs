//! The polynomial kernel.

use super::{Kernel, KernelSpec, Parameter, PerInput, Role};
use crate::GpError;

/// k(a, b) = s² (1 + Σ_d a_d b_d/l_d²)ᵖ: polynomials of degree p and less, about the origin.
///
/// Coefficients of high powers have a small variance where lengthscales are long. It is not
/// stationary: center inputs that lie far from the origin.
/// Parameters: `polynomial.lengthscale`, in the unit of input d, and `polynomial.signal_variance`.
#[derive(Clone, Debug, PartialEq)]
pub struct Polynomial {
    degree: u32,
    lengthscales: PerInput,
    signal_variance: f64,
}

impl Polynomial {
    /// A kernel of degree p with signal variance s² = k(0, 0).
    ///
    /// - `lengthscales`: one for all inputs, or one an input.
    pub fn new(degree: u32, lengthscales: PerInput, signal_variance: f64) -> Self {
        Self { degree, lengthscales, signal_variance }
    }

    /// A kernel of degree p with signal variance 1 and the same lengthscale for all inputs.
    pub fn isotropic(degree: u32, lengthscale: f64) -> Self {
        Self::new(degree, PerInput::Shared(lengthscale), 1.0)
    }

    /// A kernel of degree p with signal variance 1 and one lengthscale an input.
    pub fn ard(degree: u32, lengthscales: &[f64]) -> Self {
        Self::new(degree, lengthscales.into(), 1.0)
    }

    pub(super) fn scaled(self, factor: f64) -> Self {
        Self { signal_variance: factor * self.signal_variance, ..self }
    }

    /// 1 + Σ_d a_d b_d/l_d².
    fn base(&self, a: &[f64], b: &[f64]) -> f64 {
        let term = |(d, (a, b)): (usize, (&f64, &f64))| a * b / self.lengthscales.of(d).powi(2);
        1.0 + a.iter().zip(b).enumerate().map(term).sum::<f64>()
    }

    /// s² p (base)ᵖ⁻¹.
    fn slope(&self, a: &[f64], b: &[f64]) -> f64 {
        match self.degree.checked_sub(1) {
            None => 0.0,
            Some(less) => {
                let power = self.base(a, b).powf(f64::from(less));
                self.signal_variance * f64::from(self.degree) * power
            }
        }
    }
}

impl Kernel for Polynomial {
    fn check_n_inputs(&self, n_inputs: usize) -> Result<(), GpError> {
        self.lengthscales.check(n_inputs)
    }

    fn value(&self, a: &[f64], b: &[f64]) -> f64 {
        self.signal_variance * self.base(a, b).powf(f64::from(self.degree))
    }

    fn parameters(&self) -> Vec<Parameter> {
        let role = |inputs| Role::Lengthscale { inputs };
        let mut parameters = self.lengthscales.parameters("polynomial.lengthscale", role);
        let name = "polynomial.signal_variance";
        parameters.push(Parameter::new(name, self.signal_variance, Role::Variance));
        parameters
    }

    fn with_values(&self, values: &[f64]) -> Box<dyn Kernel> {
        let (lengthscales, variance) = values.split_at(values.len() - 1);
        let lengthscales = self.lengthscales.with_values(lengthscales);
        Box::new(Self::new(self.degree, lengthscales, variance[0]))
    }

    fn parameter_gradient(&self, a: &[f64], b: &[f64], gradient: &mut [f64]) {
        let slope = self.slope(a, b);
        gradient.fill(0.0);
        for (d, (a, b)) in a.iter().zip(b).enumerate() {
            let of_base = -2.0 * a * b / self.lengthscales.of(d).powi(2);
            gradient[self.lengthscales.slot(d)] += slope * of_base;
        }
        gradient[self.lengthscales.n_parameters()] = self.value(a, b);
    }

    fn input_gradient(&self, a: &[f64], b: &[f64], gradient: &mut [f64]) {
        let slope = self.slope(a, b);
        for (d, of_input) in gradient.iter_mut().enumerate() {
            *of_input = slope * b[d] / self.lengthscales.of(d).powi(2);
        }
    }

    fn spec(&self) -> Option<KernelSpec> {
        Some(KernelSpec::Polynomial {
            degree: self.degree,
            lengthscales: self.lengthscales.clone(),
            signal_variance: self.signal_variance,
        })
    }
}
