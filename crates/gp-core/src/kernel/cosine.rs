//! The cosine kernel.

use std::f64::consts::PI;

use super::{Kernel, KernelSpec, Parameter, PerInput, Role};
use crate::GpError;

/// k(a, b) = s² cos(2π Σ_d (a_d − b_d)/T_d): plane waves of one known period and any phase.
///
/// A function of two numbers, so it takes noise or another kernel beside it.
/// Parameters: `cosine.period`, in the unit of input d, and `cosine.signal_variance`.
#[derive(Clone, Debug, PartialEq)]
pub struct Cosine {
    periods: PerInput,
    signal_variance: f64,
}

impl Cosine {
    /// A kernel with signal variance s² = k(x, x).
    ///
    /// - `periods`: one for all inputs, or one an input.
    pub fn new(periods: PerInput, signal_variance: f64) -> Self {
        Self { periods, signal_variance }
    }

    /// A kernel with signal variance 1 and the same period for all inputs.
    pub fn isotropic(period: f64) -> Self {
        Self::new(PerInput::Shared(period), 1.0)
    }

    /// A kernel with signal variance 1 and one period an input.
    pub fn ard(periods: &[f64]) -> Self {
        Self::new(periods.into(), 1.0)
    }

    pub(super) fn scaled(self, factor: f64) -> Self {
        Self { signal_variance: factor * self.signal_variance, ..self }
    }

    /// 2π(a_d − b_d)/T_d.
    fn turn(&self, d: usize, a: &[f64], b: &[f64]) -> f64 {
        2.0 * PI * (a[d] - b[d]) / self.periods.of(d)
    }

    fn phase(&self, a: &[f64], b: &[f64]) -> f64 {
        (0..a.len()).map(|d| self.turn(d, a, b)).sum()
    }
}

impl Kernel for Cosine {
    fn check_n_inputs(&self, n_inputs: usize) -> Result<(), GpError> {
        self.periods.check(n_inputs)
    }

    fn value(&self, a: &[f64], b: &[f64]) -> f64 {
        self.signal_variance * self.phase(a, b).cos()
    }

    fn parameters(&self) -> Vec<Parameter> {
        let role = |inputs| Role::Period { inputs };
        let mut parameters = self.periods.parameters("cosine.period", role);
        let name = "cosine.signal_variance";
        parameters.push(Parameter::new(name, self.signal_variance, Role::Variance));
        parameters
    }

    fn with_values(&self, values: &[f64]) -> Box<dyn Kernel> {
        let (periods, variance) = values.split_at(values.len() - 1);
        Box::new(Self::new(self.periods.with_values(periods), variance[0]))
    }

    fn parameter_gradient(&self, a: &[f64], b: &[f64], gradient: &mut [f64]) {
        let sine = self.signal_variance * self.phase(a, b).sin();
        gradient.fill(0.0);
        for d in 0..a.len() {
            gradient[self.periods.slot(d)] += sine * self.turn(d, a, b);
        }
        gradient[self.periods.n_parameters()] = self.value(a, b);
    }

    fn input_gradient(&self, a: &[f64], b: &[f64], gradient: &mut [f64]) {
        let sine = self.signal_variance * self.phase(a, b).sin();
        for (d, slope) in gradient.iter_mut().enumerate() {
            *slope = -sine * 2.0 * PI / self.periods.of(d);
        }
    }

    fn spec(&self) -> Option<KernelSpec> {
        Some(KernelSpec::Cosine {
            periods: self.periods.clone(),
            signal_variance: self.signal_variance,
        })
    }
}
