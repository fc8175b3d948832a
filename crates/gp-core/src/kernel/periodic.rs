//! The periodic kernel.

use std::f64::consts::PI;

use super::{Kernel, KernelSpec, Parameter, PerInput, Role};
use crate::GpError;

/// k(a, b) = exp(−2 Σ_d sin²(π(a_d − b_d)/T_d)/l_d²): functions that repeat, with unit variance.
///
/// It has no variance of its own: multiply it by a number or by a kernel that has one.
/// Parameters: `periodic.period`, in the unit of input d, and `periodic.lengthscale`, without unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Periodic {
    periods: PerInput,
    lengthscales: PerInput,
}

impl Periodic {
    /// A kernel with the same period and the same lengthscale for all inputs.
    pub fn new(period: f64, lengthscale: f64) -> Self {
        Self { periods: PerInput::Shared(period), lengthscales: PerInput::Shared(lengthscale) }
    }

    /// A kernel with one period and one lengthscale an input.
    pub fn ard(periods: &[f64], lengthscales: &[f64]) -> Self {
        Self { periods: periods.into(), lengthscales: lengthscales.into() }
    }

    pub(super) fn of(periods: PerInput, lengthscales: PerInput) -> Self {
        Self { periods, lengthscales }
    }

    /// The periods T_d, each in the unit of its input: one, or one an input.
    pub fn periods(&self) -> &[f64] {
        self.periods.as_slice()
    }

    /// The lengthscales l_d, without unit: one, or one an input.
    pub fn lengthscales(&self) -> &[f64] {
        self.lengthscales.as_slice()
    }

    /// π(a_d − b_d)/T_d.
    fn phase(&self, d: usize, a: &[f64], b: &[f64]) -> f64 {
        PI * (a[d] - b[d]) / self.periods.of(d)
    }
}

impl Kernel for Periodic {
    fn check_n_inputs(&self, n_inputs: usize) -> Result<(), GpError> {
        self.periods.check(n_inputs)?;
        self.lengthscales.check(n_inputs)
    }

    fn value(&self, a: &[f64], b: &[f64]) -> f64 {
        let term = |d: usize| (self.phase(d, a, b).sin() / self.lengthscales.of(d)).powi(2);
        (-2.0 * (0..a.len()).map(term).sum::<f64>()).exp()
    }

    fn parameters(&self) -> Vec<Parameter> {
        let mut all = self.periods.parameters("periodic.period", |inputs| Role::Period { inputs });
        all.extend(self.lengthscales.parameters("periodic.lengthscale", |_| Role::Shape));
        all
    }

    fn with_values(&self, values: &[f64]) -> Box<dyn Kernel> {
        let (periods, lengthscales) = values.split_at(self.periods.n_parameters());
        let lengthscales = self.lengthscales.with_values(lengthscales);
        Box::new(Self { periods: self.periods.with_values(periods), lengthscales })
    }

    fn parameter_gradient(&self, a: &[f64], b: &[f64], gradient: &mut [f64]) {
        let value = self.value(a, b);
        let n_periods = self.periods.n_parameters();
        gradient.fill(0.0);
        for d in 0..a.len() {
            let phase = self.phase(d, a, b);
            let factor = 2.0 * value / self.lengthscales.of(d).powi(2);
            gradient[self.periods.slot(d)] += factor * phase * (2.0 * phase).sin();
            let of_lengthscale = 2.0 * factor * phase.sin().powi(2);
            gradient[n_periods + self.lengthscales.slot(d)] += of_lengthscale;
        }
    }

    fn input_gradient(&self, a: &[f64], b: &[f64], gradient: &mut [f64]) {
        let value = self.value(a, b);
        for (d, slope) in gradient.iter_mut().enumerate() {
            let factor = -2.0 * value / self.lengthscales.of(d).powi(2);
            *slope = factor * (2.0 * self.phase(d, a, b)).sin() * PI / self.periods.of(d);
        }
    }

    fn spec(&self) -> Option<KernelSpec> {
        Some(KernelSpec::Periodic {
            periods: self.periods.clone(),
            lengthscales: self.lengthscales.clone(),
        })
    }
}
