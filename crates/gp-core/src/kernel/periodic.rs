//! The periodic kernel.

use std::f64::consts::PI;

use super::{Kernel, KernelSpec, Parameter, Role};
use crate::GpError;
use crate::checks::{check_count, check_positive};

/// k(a, b) = exp(−2 Σ_d sin²(π(a_d − b_d)/T_d)/w_d²): functions that repeat, with unit variance.
///
/// It has no variance of its own: multiply it by a kernel that has one.
/// Parameters in order: the periods T_d, in the unit of input d, and the widths w_d, without unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Periodic {
    periods: Vec<f64>,
    widths: Vec<f64>,
}

impl Periodic {
    /// A kernel with one period and one width an input.
    ///
    /// # Errors
    /// `Empty` without periods; `ShapeMismatch` if the counts differ; `NotPositive` for a value that
    /// is not positive and finite.
    pub fn new(periods: &[f64], widths: &[f64]) -> Result<Self, GpError> {
        if periods.is_empty() {
            return Err(GpError::Empty { what: "periods" });
        }
        check_count("widths", periods.len(), widths.len())?;
        for (d, (&period, &width)) in periods.iter().zip(widths).enumerate() {
            check_positive(&format!("period {d}"), period)?;
            check_positive(&format!("width {d}"), width)?;
        }
        Ok(Self { periods: periods.to_vec(), widths: widths.to_vec() })
    }

    /// The periods T_d, each in the unit of its input.
    pub fn periods(&self) -> &[f64] {
        &self.periods
    }

    /// The widths w_d, without unit.
    pub fn widths(&self) -> &[f64] {
        &self.widths
    }

    /// π(a_d − b_d)/T_d.
    fn phase(&self, d: usize, a: &[f64], b: &[f64]) -> f64 {
        PI * (a[d] - b[d]) / self.periods[d]
    }
}

impl Kernel for Periodic {
    fn n_inputs(&self) -> usize {
        self.periods.len()
    }

    fn value(&self, a: &[f64], b: &[f64]) -> f64 {
        let term = |d: usize| (self.phase(d, a, b).sin() / self.widths[d]).powi(2);
        (-2.0 * (0..self.periods.len()).map(term).sum::<f64>()).exp()
    }

    fn parameters(&self) -> Vec<Parameter> {
        let period = |(input, &value): (usize, &f64)| Parameter {
            name: format!("period {input}"),
            value,
            role: Role::Period { input },
        };
        let width = |(input, &value): (usize, &f64)| Parameter {
            name: format!("width {input}"),
            value,
            role: Role::Shape,
        };
        let periods = self.periods.iter().enumerate().map(period);
        periods.chain(self.widths.iter().enumerate().map(width)).collect()
    }

    fn with_parameters(&self, values: &[f64]) -> Result<Box<dyn Kernel>, GpError> {
        check_count("kernel parameters", 2 * self.periods.len(), values.len())?;
        let (periods, widths) = values.split_at(self.periods.len());
        Ok(Box::new(Self::new(periods, widths)?))
    }

    fn parameter_gradient(&self, a: &[f64], b: &[f64], gradient: &mut [f64]) {
        let value = self.value(a, b);
        let n_inputs = self.periods.len();
        for d in 0..n_inputs {
            let phase = self.phase(d, a, b);
            let factor = 2.0 * value / (self.widths[d] * self.widths[d]);
            gradient[d] = factor * phase * (2.0 * phase).sin();
            gradient[n_inputs + d] = 2.0 * factor * phase.sin().powi(2);
        }
    }

    fn input_gradient(&self, a: &[f64], b: &[f64], gradient: &mut [f64]) {
        let value = self.value(a, b);
        for (d, slope) in gradient.iter_mut().enumerate() {
            let factor = -2.0 * value / (self.widths[d] * self.widths[d]);
            *slope = factor * (2.0 * self.phase(d, a, b)).sin() * PI / self.periods[d];
        }
    }

    fn spec(&self) -> Option<KernelSpec> {
        Some(KernelSpec::Periodic { periods: self.periods.clone(), widths: self.widths.clone() })
    }
}
